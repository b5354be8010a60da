// SPDX-License-Identifier: Apache-2.0
// Describes a command line for its reference page, manual pages and completion of shells: commands, options, values and
// defaults, read from the CLI11 app that parses them.
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace multum {

struct OptionText {
  std::string short_name;  // "-o"; empty: none
  std::string long_name;   // "--output"; empty: positional only
  std::string positional;  // "input"; empty: none
  std::string value;       // "FILE", "1 to 8"; empty: a flag, or a choice
  std::vector<std::string> choices;
  std::string default_text;  // empty: none
  std::string help;
  std::string group;
  bool is_flag = false, is_required = false, is_repeatable = false;

  /// "--output", or "input" for a positional.
  const std::string& name() const { return long_name.empty() ? positional : long_name; }
  /// "1 to 8", "a, b or c"; empty for a flag.
  std::string values() const;
};

struct CommandText {
  std::string words;  // "multum jobs list"
  std::string name;   // "list"
  std::string group;  // heading in the help of its parent
  std::string help;
  std::string examples;               // lines that end its help
  std::vector<OptionText> options;    // visible ones, positionals first
  std::vector<CommandText> commands;  // visible ones
  bool needs_command = false;

  /// "multum bake [OPTION...] [input...]".
  std::string usage() const;
};

/// Describes an app with all its visible subcommands.
CommandText describe(const CLI::App& app);

}  // namespace multum
