// SPDX-License-Identifier: Apache-2.0
// Jobs that do nothing, or fail as asked (docs/SERVICE.md, "Drills").
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"

namespace multum {

/// `arguments` as job_arguments() makes them of a drill. Sets `is_deaf` to hang without a heartbeat.
int run_fault_injection(const std::vector<std::string>& arguments, Progress& progress, std::atomic<bool>& is_deaf);

}  // namespace multum
