// SPDX-License-Identifier: Apache-2.0
// Estimates what a job takes before it is sent to Slurm: how many share a task, which maps are divided, and time limits
// follow from it.
#pragma once

#include <string>
#include <vector>

#include "host/farm/service/slurm/slurm_plan.h"
#include "host/farm/service/slurm/slurm_settings.h"
#include "host/farm/service/workers/worker_pool.h"

namespace multum {

/// By the type's estimate_command, as `multum plan` is a bake's, in a child that is confined to `roots` and held to
/// memory and time, since the map is a client's; else by its estimated_seconds(). Of types without either, and where
/// the child fails, nothing is known. Blocks.
SlurmEstimate estimate_work(const WorkOrder& work, const SlurmSettings& settings,
                            const std::vector<std::string>& roots);

}  // namespace multum
