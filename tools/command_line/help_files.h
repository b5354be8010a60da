// SPDX-License-Identifier: Apache-2.0
// Makes the reference page, manual pages and completion scripts of a program from its CLI11 app.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

#include "tools/command_line/completion_scripts.h"

namespace multum {

/// Returns the part of docs/reference/commands.md that describes the program. For multum, this part includes the head
/// of the page.
std::string command_page_of(const CLI::App& program);

/// Writes the manual pages into a folder, which is created if it is missing. Returns the number of pages.
int write_man_pages(const CLI::App& program, const std::string& folder);

/// Returns the completion script for one of the shells in kShells.
std::string completion_of(const CLI::App& program, const std::string& shell);

}  // namespace multum
