// SPDX-License-Identifier: Apache-2.0
// Names options in advice as the command that runs has them. Code that several commands share writes its advice with
// this, so that no command advises an option that it lacks (tools/check_advice.py).
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace multum {

/// Sets the options of the command that runs, for the whole process, before its work begins: names of parameters, such
/// as "two_channel". nullopt, as it is at first: every parameter is an option.
void set_option_words(std::optional<std::set<std::string>> names);

/// Adds parameters that are given in a file, by green = "down": those of a manifest or a scene.
void add_key_words(const std::vector<std::string>& names);

/// "green" and "down" as "--green down", or as a file has them. nullopt: the command has no such parameter. An empty
/// value: a flag.
std::optional<std::string> option_text(const std::string& name, const std::string& value = "");

/// Replaces every "<name>" and "<name value>" of the text by its option. Returns "" where the command lacks one of
/// them: a piece of advice is a text of its own, to be appended to a message that is whole without it. Marks, which
/// Error and the log take away, tell it from the rest of the message.
std::string advice(const std::string& text);

/// The options of these parameters as advice: ": --green, --signed".
std::string names_as_advice(const std::vector<std::string>& names);

/// The message without the marks, as people read it.
std::string with_advice(std::string message);
std::vector<std::string> with_advice(std::vector<std::string> messages);
/// The message without the advice, which is the same whatever command runs: for what is stored in files.
std::string without_advice(const std::string& message);

}  // namespace multum
