// SPDX-License-Identifier: Apache-2.0
// Runs another program and waits for it. Work that needs GL runs in a child, multum-view, so that a driver crash ends
// only the child. Benchmarks run whole programs and measure them.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace multum {

/// Time and memory of a child and of the descendants that it waited for.
struct ChildUsage {
  double wall_seconds;    // wall time from before the child's start to the end of the wait
  double user_seconds;    // processor time in user mode, all threads
  double system_seconds;  // processor time in the kernel, all threads
  /// Largest resident memory of the child or one of its descendants. Linux also counts the caller's peak memory before
  /// the child begins, so this value is never less than own_peak_memory_bytes(). A caller that measures should
  /// therefore use little memory.
  std::uint64_t peak_memory_bytes;

  double cpu_seconds() const { return user_seconds + system_seconds; }
};

struct ChildResult {
  int exit_code;       // -1 if a signal ended the child
  int signal;          // 0 when it exited
  std::string output;  // stdout and stderr, interleaved
  ChildUsage usage;
  bool is_over_time = false;  // true if the child was killed because it took too long, was cancelled, or wrote too much
};

/// Limits of a child that reads untrusted files. A child with limits has its own process group: Ctrl-C does not reach
/// it, and killing it also kills the processes that it has started.
struct ChildLimits {
  std::chrono::milliseconds time_max{};     // the child is killed after this time
  int niceness = 0;                         // 0 to 19
  std::uint64_t memory_max = 0;             // limit on writable bytes; 0 sets no limit. Has no effect with
                                            // -fsanitize=address or thread
  std::size_t output_max = 64 << 20;        // bytes of output; a child that writes more is killed
  std::function<bool()> is_cancelled = {};  // called ten times per second; if it returns true, the child is killed
};

/// Runs `arguments[0]` (looked up in PATH). The child inherits no files except stdin, and is killed when this process
/// ends in any way. Throws Error(kEnvironment) when it cannot be started.
ChildResult run_child(const std::vector<std::string>& arguments);
ChildResult run_child(const std::vector<std::string>& arguments, const ChildLimits& limits);

/// Largest resident memory of this process so far.
std::uint64_t own_peak_memory_bytes();

}  // namespace multum
