// SPDX-License-Identifier: Apache-2.0
// Writes manual pages from the description of a command line.
#pragma once

#include <map>
#include <string>

#include "tools/command_line/command_text.h"

namespace multum {

/// Manual pages in roff (man(7)), by file name: one for the program and one for each of its commands, "multum-bake.1".
/// A page of a command also describes the subcommands of that command.
std::map<std::string, std::string> man_pages(const CommandText& program, const std::string& version);

}  // namespace multum
