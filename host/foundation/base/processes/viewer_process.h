// SPDX-License-Identifier: Apache-2.0
// Runs multum-view, which needs GL, as a child process, so that a driver crash ends only the child.
#pragma once

#include <string>
#include <vector>

#include "host/foundation/base/progress.h"

namespace multum {

/// Returns the multum-view in program_folder(), where a build and an installation have it. If there is none, returns
/// the plain name, which is then searched for in PATH.
std::string find_viewer();

/// Runs `command` and waits for it. Shows its output if the log is verbose. If multum-view refuses a file (exit code 3)
/// or leaves out damaged parts of it (exit code 5), throws its error: Error(kInput) or Error(kVerification). If the
/// child cannot be started, fails otherwise or crashes, throws Error(kEnvironment) with `what` and the child's output.
/// If `progress` was cancelled during this time, throws Cancelled instead. Ctrl-C on a terminal also ends the child,
/// and this is not a failure.
void run_viewer(const std::vector<std::string>& command, const std::string& what, Progress* progress);

}  // namespace multum
