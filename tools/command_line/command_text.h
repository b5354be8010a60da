// SPDX-License-Identifier: Apache-2.0
// Describes the commands, options, values and defaults of a command line, for its reference page, manual pages and
// shell completion. They are read from the CLI11 app that parses the command line.
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace multum {

struct OptionText {
  std::string short_name;  // such as "-o"; empty if there is none
  std::string long_name;   // such as "--output"; empty if the option is only positional
  std::string positional;  // such as "input"; empty if the option is not positional
  std::string value;       // such as "FILE" or "1 to 8"; empty for a flag or a choice
  std::vector<std::string> choices;
  std::string default_text;  // empty if there is no default
  std::string help;
  std::string group;
  bool is_flag = false, is_required = false, is_repeatable = false;

  /// Returns a name such as "--output", or "input" for a positional.
  const std::string& name() const { return long_name.empty() ? positional : long_name; }
  /// Returns a text such as "1 to 8" or "a, b or c", or an empty text for a flag.
  std::string values() const;
};

struct CommandText {
  std::string words;  // such as "multum jobs list"
  std::string name;   // such as "list"
  std::string group;  // heading of the command in the help of its parent
  std::string help;
  std::string examples;               // last lines of the help text
  std::vector<OptionText> options;    // visible options, positionals first
  std::vector<CommandText> commands;  // visible commands
  bool needs_command = false;

  /// Returns the usage line, such as "multum bake [OPTION...] [input...]".
  std::string usage() const;
};

/// Describes an app with all of its visible subcommands.
CommandText describe(const CLI::App& app);

}  // namespace multum
