// SPDX-License-Identifier: Apache-2.0
// Writes docs/reference/commands.md from the description of a command line and the tables of parameters.
#pragma once

#include <string>

#include "tools/command_line/command_text.h"

namespace multum {

/// Title and introduction of the page.
std::string command_page_head();

/// The sections of one program in Markdown: a list of its commands, a section of the options that many commands share,
/// and a section per command. An option is described once; other commands with the same option name it. A parameter has
/// its keys in manifests, scenes and jobs next to its option.
std::string command_page_part(const CommandText& program);

}  // namespace multum
