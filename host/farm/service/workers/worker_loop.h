// SPDX-License-Identifier: Apache-2.0
// The worker's side of the service: a process that is told one job after the other, says every second that it lives,
// and how far it has come. When the daemon is gone it ends at once: its lease is nobody's.
//
// Both sides write JSON objects, one a line, over a stream socket:
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

/// Does what a command line of multum says and returns its exit code; what it prints goes to the job's log. It says how
/// far it is to the callback, which may cancel it.
using RunCommand = std::function<int(const std::vector<std::string>& arguments, const Progress::Callback& callback)>;

/// Until the daemon says so, or is gone. What a job reads and where its result is to be must lie below `roots`, where
/// the daemon has looked before. Returns the exit code of the process.
int run_worker(int socket, const std::vector<std::string>& roots, const RunCommand& run);

}  // namespace multum
