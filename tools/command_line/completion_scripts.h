// SPDX-License-Identifier: Apache-2.0
// Writes completion scripts for shells from the description of a command line.
#pragma once

#include <string>

#include "tools/command_line/command_text.h"

namespace multum {

/// The shells that completion_script() supports.
inline const std::vector<std::string> kShells = {"bash", "zsh", "fish"};

/// Returns a script that completes commands, options and choices of `program`, and file names everywhere else. The
/// script can be sourced in bash, in zsh after compinit, and in fish. fish also finds it as completions/PROGRAM.fish.
std::string completion_script(const CommandText& program, const std::string& shell);

}  // namespace multum
