// SPDX-License-Identifier: Apache-2.0
// Runs another program and waits for it: what needs GL runs multum-view as a child, so that a driver crash ends the
// child alone.
#pragma once

#include <string>
#include <vector>

namespace multum {

struct ChildResult {
  int exit_code;       // -1 when a signal ended it
  int signal;          // 0 when it exited
  std::string output;  // stdout and stderr, interleaved
};

/// `arguments[0]` is the program (looked up in PATH). Throws Error(kEnvironment) when it cannot be started.
ChildResult run_child(const std::vector<std::string>& arguments);

}  // namespace multum
