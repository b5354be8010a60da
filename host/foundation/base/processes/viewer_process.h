// SPDX-License-Identifier: Apache-2.0
// multum-view as a child process: what needs GL runs there, and a driver's crash ends it alone.
#pragma once

#include <string>
#include <vector>

#include "host/foundation/base/progress.h"

namespace multum {

/// Runs `command` to its end; what it prints is shown when verbose. Throws Error(kEnvironment) with what it said when
/// it cannot be started, fails or crashes, beginning with `what`; Cancelled when `progress` was cancelled meanwhile:
/// Ctrl-C on a terminal ends the child too, and that is no failure.
void run_viewer(const std::vector<std::string>& command, const std::string& what, Progress* progress);

}  // namespace multum
