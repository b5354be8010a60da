// SPDX-License-Identifier: Apache-2.0
// Runs a Slurm task on a node. Reads its order in the shared folder, and lets a worker do the items one after the
// other. The daemon uses workers in the same way on its own machine (worker_pool.h).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/slurm/slurm_folder.h"

namespace multum {

/// Returns the command line of a worker for an order. The worker may write to the given folder.
using SlurmWorkerCommand =
    std::function<std::vector<std::string>(const SlurmOrder& order, const std::string& work_folder)>;

/// Does all unfinished items of a batch, or the item of an array's task. Returns the exit code of the process. The exit
/// code is 0 when all items have ended in any way or their order was removed, and 130 after SIGTERM. Throws
/// Error(kEnvironment).
int run_slurm_task(const std::string& batch_folder, std::optional<int> array_item, const SlurmWorkerCommand& command);

}  // namespace multum
