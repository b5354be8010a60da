// SPDX-License-Identifier: Apache-2.0
// Refuses old names of commands, and commands that this build of a program does not include.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace multum {

/// Adds hidden commands that accept any options and throw Error(kUsage), because this build does not include `part`.
/// The message names the CMake option that adds it.
void add_absent_commands(CLI::App& app, const std::vector<std::string>& names, const std::string& part,
                         const std::string& option);

/// Adds a hidden command that accepts any options and throws Error(kUsage) with its new name, such as "jobs submit".
void add_moved_command(CLI::App& app, const std::string& name, const std::string& new_name);

}  // namespace multum
