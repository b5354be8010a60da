// SPDX-License-Identifier: Apache-2.0
// Starts another program. The caller must wait for the program, and end it if necessary.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace multum {

struct SpawnSettings {
  /// Pairs of a descriptor of this process and its number in the child. The pairs are applied in this order. The first
  /// number of a pair must not equal the second number of an earlier pair. The child gets only these descriptors, in
  /// addition to stdin, stdout and stderr.
  std::vector<std::pair<int, int>> files = {};
  bool has_empty_input = false;  // if true, stdin is /dev/null instead of the stdin of this process
  bool has_own_group = false;    // terminal signals do not reach the child; a signal to -pid reaches its whole group
  bool is_in_path = false;       // the program is looked up in PATH
  /// Kills the child when the thread that starts it ends in any way. Must be false if the thread passes the child to
  /// other threads.
  bool ends_with_thread = false;
  /// The signals that are blocked in the child. All other signals are unblocked and have their default action. With
  /// nullopt, the child inherits the signal settings of this process, except for SIGXFSZ. This process ignores SIGXFSZ
  /// (run_guarded()), but the child has the default action.
  std::optional<std::vector<int>> blocked_signals = {};
};

/// Starts the program `arguments[0]` with the environment of this process. Throws Error(kEnvironment) when it cannot be
/// started.
pid_t spawn_process(const std::vector<std::string>& arguments, const SpawnSettings& settings);

}  // namespace multum
