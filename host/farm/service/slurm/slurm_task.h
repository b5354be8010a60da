// SPDX-License-Identifier: Apache-2.0
// The node's side of what is sent to Slurm: a task that reads its order in the shared folder and has it done by a
// worker, one item after the other, as the daemon does on its own machine (worker_pool.h).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/slurm/slurm_folder.h"

namespace multum {

/// The command line of a worker of an order, with the folder that it may write.
using SlurmWorkerCommand =
    std::function<std::vector<std::string>(const SlurmOrder& order, const std::string& work_folder)>;

/// Does the items of a batch that have not ended, or that of an array's task. Returns the exit code of the process: 0
/// when all have ended, however, or are nobody's any more; 130 when SIGTERM came before. Throws Error(kEnvironment).
int run_slurm_task(const std::string& batch_folder, std::optional<int> array_item, const SlurmWorkerCommand& command);

}  // namespace multum
