// SPDX-License-Identifier: Apache-2.0
// The worker's side of the service: a process that runs one job after another, and reports every second that it is
// alive, and its progress. When the daemon has ended, the worker ends at once, because its lease is void.
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

/// Runs a command line of multum and returns its exit code; its output goes to the job's log. Reports progress to the
/// callback, which may cancel the command.
using RunCommand = std::function<int(const std::vector<std::string>& arguments, const Progress::Callback& callback)>;

/// Runs until the daemon tells it to end, or has ended itself. A job's inputs and its result must be below `roots`; the
/// daemon has checked this before. Returns the exit code of the process.
int run_worker(int socket, const std::vector<std::string>& roots, const RunCommand& run);

}  // namespace multum
