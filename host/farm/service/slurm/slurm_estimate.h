// SPDX-License-Identifier: Apache-2.0
// Estimates a job's cost before it is sent to Slurm. The estimate determines how many jobs share a task, which maps are
// divided, and the time limits.
#pragma once

#include <string>
#include <vector>

#include "host/farm/service/slurm/slurm_plan.h"
#include "host/farm/service/slurm/slurm_settings.h"
#include "host/farm/service/workers/worker_pool.h"

namespace multum {

/// Runs the type's estimate_command (for bakes, `multum plan`) in a child process. The child is confined to `roots`,
/// with limits of memory and time, because the map belongs to a client. If the type has no such command, uses
/// estimated_seconds(). If it has neither, or the child fails, the cost is unknown. Blocks.
SlurmEstimate estimate_work(const WorkOrder& work, const SlurmSettings& settings,
                            const std::vector<std::string>& roots);

}  // namespace multum
