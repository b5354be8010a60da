// SPDX-License-Identifier: Apache-2.0
// The commands of a part that this build of a program leaves out.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace multum {

/// Commands that the help does not show. Whatever their options, each throws Error(kUsage), which says that this build
/// has no `part` and which option of CMake adds it.
void add_absent_commands(CLI::App& app, const std::vector<std::string>& names, const std::string& part,
                         const std::string& option);

}  // namespace multum
