// SPDX-License-Identifier: Apache-2.0
// Starts another program; how long it lives, and how it ends, is its starter's.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace multum {

struct SpawnSettings {
  /// Descriptors of this process and what they are in the child, given in this order: none may be among those before
  /// it. The child has these and its first three, and no others.
  std::vector<std::pair<int, int>> files = {};
  bool has_empty_input = false;  // its stdin is /dev/null, not this process's
  bool has_own_group = false;    // signals of a terminal do not reach it, and a signal to -pid all that it has started
  bool is_in_path = false;       // the program is looked up in PATH
  /// It is killed when the thread that starts it ends, however that ends. Not for a thread that hands it on to others.
  bool ends_with_thread = false;
  /// Signals that it has blocked; all others are open to it, and each acts as at a program's start. nullopt: all are as
  /// they are here, but SIGXFSZ, which this process ignores (run_guarded()), acts as at a program's start.
  std::optional<std::vector<int>> blocked_signals = {};
};

/// `arguments[0]` is the program. Its environment is this process's. Throws Error(kEnvironment) when it cannot be
/// started.
pid_t spawn_process(const std::vector<std::string>& arguments, const SpawnSettings& settings);

}  // namespace multum
