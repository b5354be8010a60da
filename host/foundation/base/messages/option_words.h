// SPDX-License-Identifier: Apache-2.0
// Writes the names of options in advice as the running command spells them. Code that several commands share writes its
// advice with these functions, so that no command recommends an option that it lacks (tools/check_advice.py).
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace multum {

/// Sets the options of the running command for the whole process, before the work begins. The options are given as
/// names of parameters, such as "two_channel". With nullopt, the default, every parameter is an option.
void set_option_words(std::optional<std::set<std::string>> names);

/// Adds parameters that are keys of a file, such as a manifest or a scene (green = "down").
void add_key_words(const std::vector<std::string>& names);

/// Formats "green" and "down" as "--green down", or as a key of a file. Returns nullopt if the command has no such
/// parameter. An empty value means that the parameter is a flag.
std::optional<std::string> option_text(const std::string& name, const std::string& value = "");

/// Replaces every "<name>" and "<name value>" in the text by the option. Returns "" if the command lacks one of the
/// options. Advice is a separate text that is appended to a message, and the message is complete without it. Invisible
/// marks separate the advice from the message. Error and the log remove these marks.
std::string advice(const std::string& text);

/// Returns the options of these parameters in the form of advice: ": --green, --signed".
std::string names_as_advice(const std::vector<std::string>& names);

/// Returns the message without the marks, for output to users.
std::string with_advice(std::string message);
std::vector<std::string> with_advice(std::vector<std::string> messages);
/// Returns the message without its advice, which depends on the command. This form is used for messages that are stored
/// in files.
std::string without_advice(const std::string& message);

}  // namespace multum
