// SPDX-License-Identifier: Apache-2.0
// Writes completion scripts for shells from the description of a command line.
#pragma once

#include <string>

#include "tools/command_line/command_text.h"

namespace multum {

/// The shells that completion_script() supports.
inline const std::vector<std::string> kShells = {"bash", "zsh", "fish"};

/// Returns a script that completes commands, options and choices of `program`, and file names elsewhere. bash sources
/// the script, and so does zsh after compinit. fish sources the script or finds it as completions/PROGRAM.fish.
std::string completion_script(const CommandText& program, const std::string& shell);

}  // namespace multum
