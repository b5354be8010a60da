// SPDX-License-Identifier: Apache-2.0
// Finds the command that a parsed command line chose.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace multum {

/// Returns the innermost subcommand that was parsed, such as `list` for "multum jobs list". Without subcommands,
/// returns `app`.
inline const CLI::App& chosen_command(const CLI::App& app) {
  const CLI::App* command = &app;
  for (;;) {
    const auto parsed = command->get_subcommands([](const CLI::App* one) { return one->parsed(); });
    if (parsed.empty()) return *command;
    command = parsed.front();
  }
}

/// Returns the words that call a command, such as "multum jobs list".
inline std::string command_words(const CLI::App& command) {
  const CLI::App* const parent = command.get_parent();
  return parent == nullptr ? command.get_name() : command_words(*parent) + " " + command.get_name();
}

}  // namespace multum
