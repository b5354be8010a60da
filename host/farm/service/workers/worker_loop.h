// SPDX-License-Identifier: Apache-2.0
// Runs a worker of the service: a process that runs one job after another. Every second it reports its progress, and
// that it is alive. When the daemon has ended, the worker ends at once, because its lease is void.
//
// Both sides write JSON objects, one per line, over a stream socket:
//
//   daemon   {"run": ID, "attempt": N, "type": NAME, "parameters": {...}, "output": PATH or "", ...}  (work_order.h)
//            {"cancel": ID}
//            {"end": true}
//   worker   {"ready": true}
//            {"beat": true}
//            {"progress": {"stage", "done", "total"}}
//            {"ended": ID, "attempt": N, "exit_code": N, "message": TEXT, "inputs_changed": true or false}
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"

namespace multum {

/// Runs a command line of multum and returns its exit code. Its output goes to the job's log. Reports progress to the
/// callback, which may cancel the command.
using RunCommand = std::function<int(const std::vector<std::string>& arguments, const Progress::Callback& callback)>;

/// Runs until the daemon ends or tells the worker to end. A job's inputs and its result must be below `roots`, which
/// the daemon has already checked. Returns the exit code of the process.
int run_worker(int socket, const std::vector<std::string>& roots, const RunCommand& run);

}  // namespace multum
