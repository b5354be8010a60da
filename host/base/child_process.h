// SPDX-License-Identifier: Apache-2.0
// Runs another program and waits for it: what needs GL runs multum-view as a child, so that a driver crash ends the
// child alone; benchmarks run whole programs, and learn what they cost.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace multum {

/// What a child took, with the children that it waited for itself.
struct ChildUsage {
  double wall_seconds;    // from before it was started until it was waited for
  double user_seconds;    // processor time of all its threads
  double system_seconds;  // the same in the kernel
  /// Largest resident memory; of a family the largest process's. Linux counts what the caller's own memory was at its
  /// largest before it lets the child begin, so this is never less than own_peak_memory_bytes(): a caller that measures
  /// stays small.
  std::uint64_t peak_memory_bytes;

  double cpu_seconds() const { return user_seconds + system_seconds; }
};

struct ChildResult {
  int exit_code;       // -1 when a signal ended it
  int signal;          // 0 when it exited
  std::string output;  // stdout and stderr, interleaved
  ChildUsage usage;
};

/// `arguments[0]` is the program (looked up in PATH). Throws Error(kEnvironment) when it cannot be started.
ChildResult run_child(const std::vector<std::string>& arguments);

/// Largest resident memory of this process so far.
std::uint64_t own_peak_memory_bytes();

}  // namespace multum
