// SPDX-License-Identifier: Apache-2.0
// Starts another program; the caller waits for it and ends it.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace multum {

struct SpawnSettings {
  /// Pairs of a descriptor of this process and its number in the child, applied in this order: no first number may be
  /// among the second numbers before it. The child has only these and its first three descriptors.
  std::vector<std::pair<int, int>> files = {};
  bool has_empty_input = false;  // stdin is /dev/null, not the stdin of this process
  bool has_own_group = false;    // a terminal's signals do not reach it; a signal to -pid reaches all its children
  bool is_in_path = false;       // the program is looked up in PATH
  /// Kills the child when the thread that starts it ends in any way. Not for a thread that hands the child to others.
  bool ends_with_thread = false;
  /// Signals that are blocked in the child; all others are unblocked and have their default action. nullopt: signals
  /// are inherited, except that SIGXFSZ, which this process ignores (run_guarded()), has its default action.
  std::optional<std::vector<int>> blocked_signals = {};
};

/// Starts the program `arguments[0]` with the environment of this process. Throws Error(kEnvironment) when it cannot be
/// started.
pid_t spawn_process(const std::vector<std::string>& arguments, const SpawnSettings& settings);

}  // namespace multum
