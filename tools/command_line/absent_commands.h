// SPDX-License-Identifier: Apache-2.0
// Refuses commands that this build of a program leaves out, and former names of commands.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace multum {

/// Adds hidden commands that take any options and throw Error(kUsage): this build has no `part`; `option` of CMake adds
/// it.
void add_absent_commands(CLI::App& app, const std::vector<std::string>& names, const std::string& part,
                         const std::string& option);

/// Adds a hidden command that takes any options and throws Error(kUsage) with its new name, "jobs submit".
void add_moved_command(CLI::App& app, const std::string& name, const std::string& new_name);

}  // namespace multum
