// SPDX-License-Identifier: Apache-2.0
// Runs another program and waits for it: what needs GL runs multum-view as a child, so that a driver crash ends the
// child alone; benchmarks run whole programs, and learn what they cost.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace multum {

/// Time and memory that a child took, with the children that it waited for itself.
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
  bool is_over_time = false;  // or not wanted any more, or said too much: it was killed
};

/// Limits of a child that works on files of strangers. One with limits has a process group of its own: Ctrl-C does not
/// reach it, and what it has started ends with it when it is killed.
struct ChildLimits {
  std::chrono::milliseconds time_max{};     // then it is killed
  int niceness = 0;                         // 0..19
  std::uint64_t memory_max = 0;             // bytes that it may write to; 0: any. Not with -fsanitize=address or thread
  std::size_t output_max = 64 << 20;        // bytes of what it says; one that says more is killed
  std::function<bool()> is_cancelled = {};  // asked ten times a second; true: it is killed
};

/// `arguments[0]` is the program (looked up in PATH). It inherits no files but stdin, and is killed when this process
/// ends, however that ends. Throws Error(kEnvironment) when it cannot be started.
ChildResult run_child(const std::vector<std::string>& arguments);
ChildResult run_child(const std::vector<std::string>& arguments, const ChildLimits& limits);

/// Largest resident memory of this process so far.
std::uint64_t own_peak_memory_bytes();

}  // namespace multum
