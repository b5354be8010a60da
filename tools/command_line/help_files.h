// SPDX-License-Identifier: Apache-2.0
// Makes the reference page, manual pages and completion scripts of a program from its CLI11 app.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

#include "tools/command_line/completion_scripts.h"

namespace multum {

/// The part of docs/reference/commands.md about the program; for multum with the head of the page.
std::string command_page_of(const CLI::App& program);

/// Writes the manual pages into a folder, which is made if it is missing; returns how many.
int write_man_pages(const CLI::App& program, const std::string& folder);

/// The completion script for a shell of kShells.
std::string completion_of(const CLI::App& program, const std::string& shell);

}  // namespace multum
