// SPDX-License-Identifier: Apache-2.0
// Writes manual pages from the description of a command line.
#pragma once

#include <map>
#include <string>

#include "tools/command_line/command_text.h"

namespace multum {

/// Returns manual pages in roff (man(7)) by file name, one for the program and one for each command, such as
/// "multum-bake.1". The page of a command also describes its subcommands.
std::map<std::string, std::string> man_pages(const CommandText& program, const std::string& version);

}  // namespace multum
