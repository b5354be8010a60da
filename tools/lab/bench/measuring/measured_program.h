// SPDX-License-Identifier: Apache-2.0
// Runs a whole program as a child process, waits until its output is synced, and measures its costs.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"

namespace multum::bench {

struct ProgramCost {
  double wall_seconds;  // elapsed time until the output is on disk
  double cpu_seconds;   // user and system time of all threads
  double peak_mib;      // largest resident memory; at least the memory of this process
                        // (host/foundation/base/processes/child_process.h)
  double output_mb;     // size in MB of 10^6 bytes
};

/// Runs a command that must write `output`, then syncs the file. First removes an older file, without timing it. If the
/// command fails, throws Error with the end of its output: kUsage for the exit code of usage errors, otherwise
/// kEnvironment.
ProgramCost run_to_disk(const std::vector<std::string>& command, const std::string& output, Progress* progress);
/// The same for a command that writes several files.
ProgramCost run_to_disk(const std::vector<std::string>& command, const std::vector<std::string>& outputs,
                        Progress* progress);

/// Returns the end of a program's output, for error messages.
std::string last_words(const std::string& output);

/// Returns medians and quartiles over runs: {"wall_s": ..., "cpu_s": ..., "peak_mib": ..., "output_mb": ...}.
nlohmann::ordered_json costs_json(const std::vector<ProgramCost>& costs);

}  // namespace multum::bench
