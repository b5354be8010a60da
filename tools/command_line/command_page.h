// SPDX-License-Identifier: Apache-2.0
// Writes docs/reference/commands.md from the description of a command line and the tables of parameters.
#pragma once

#include <string>

#include "tools/command_line/command_text.h"

namespace multum {

/// Returns the title and introduction of the page.
std::string command_page_head();

/// Returns the sections of one program in Markdown. They are a list of its commands, a section for the options that
/// many commands share, and one section per command. Each option is described once, and other commands with the same
/// option only name it. The keys of a parameter in manifests, scenes and jobs are listed next to its option.
std::string command_page_part(const CommandText& program);

}  // namespace multum
