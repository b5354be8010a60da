// SPDX-License-Identifier: Apache-2.0
// A whole program as a child process, from file to synced file: what it costs.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"

namespace multum::bench {

struct ProgramCost {
  double wall_seconds;  // until the output is on the disk
  double cpu_seconds;   // user and system, all threads
  double peak_mib;      // largest resident memory; never less than this process's own
                        // (host/foundation/base/processes/child_process.h)
  double output_mb;     // of 10^6 bytes
};

/// Runs a command that must write `output`, then syncs it. A file of that name is removed first, untimed. Throws Error
/// with the end of what the command said when it fails: kUsage when its exit code says so, else kEnvironment.
ProgramCost run_to_disk(const std::vector<std::string>& command, const std::string& output, Progress* progress);

/// The end of what a program said, for a message that says how it failed.
std::string last_words(const std::string& output);

/// Medians and quartiles of some runs of a program: {"wall_s": ..., "cpu_s": ..., "peak_mib": ..., "output_mb": ...}.
nlohmann::ordered_json costs_json(const std::vector<ProgramCost>& costs);

}  // namespace multum::bench
