// SPDX-License-Identifier: Apache-2.0
// Runs another program and waits for it. Work that needs GL runs in a child process, multum-view, so that a driver
// crash ends only the child. Benchmarks use this code to run whole programs and measure them.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace multum {

/// Time and memory that a child and its descendants used, if the child waited for them.
struct ChildUsage {
  double wall_seconds;    // wall time from before the child's start to the end of the wait
  double user_seconds;    // processor time of all threads in user mode
  double system_seconds;  // processor time of all threads in the kernel
  /// The largest resident memory of the child or of one of its descendants. Linux also counts the peak memory that the
  /// caller had before the child began, so this value is never less than own_peak_memory_bytes(). A caller that
  /// measures should therefore use little memory.
  std::uint64_t peak_memory_bytes;

  double cpu_seconds() const { return user_seconds + system_seconds; }
};

struct ChildResult {
  int exit_code;       // -1 if a signal ended the child
  int signal;          // 0 if the child exited by itself
  std::string output;  // stdout and stderr, interleaved
  ChildUsage usage;
  bool is_over_time = false;  // true if the child was killed because it took too long, was cancelled, or wrote too much
};

/// Limits of a child that reads untrusted files. A child with limits has its own process group. Therefore Ctrl-C does
/// not reach it, and killing it also kills the processes that it has started.
struct ChildLimits {
  std::chrono::milliseconds time_max{};     // the child is killed after this time
  int niceness = 0;                         // 0 to 19
  std::uint64_t memory_max = 0;             // limit on writable bytes; 0 sets no limit; has no effect with
                                            // -fsanitize=address or -fsanitize=thread
  std::size_t output_max = 64 << 20;        // limit on the bytes of output; a child that writes more is killed
  std::function<bool()> is_cancelled = {};  // called ten times per second; if it returns true, the child is killed
};

/// Runs `arguments[0]` (looked up in PATH). The child inherits no files except for stdin, and is killed when this
/// process ends in any way. Throws Error(kEnvironment) if the program cannot be started.
ChildResult run_child(const std::vector<std::string>& arguments);
ChildResult run_child(const std::vector<std::string>& arguments, const ChildLimits& limits);

/// Returns the largest resident memory of this process so far.
std::uint64_t own_peak_memory_bytes();

}  // namespace multum
