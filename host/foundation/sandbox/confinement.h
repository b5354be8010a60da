// SPDX-License-Identifier: Apache-2.0
// Bars a process from files that it does not need, with Linux's Landlock. Whatever path, link or library the process
// and its children follow later, the system opens only the allowed files. Newer kernels also bar it from TCP (6.7), and
// from sending signals to processes that are not confined with it (6.12). Landlock needs no privilege and cannot be
// undone.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace multum {

struct Confinement {
  /// Files, or folders with their contents; missing ones are skipped.
  std::vector<std::string> readable, writable;
};

/// Returns an environment variable's value; "" if it is not set.
using Variables = std::function<std::string(const char* name)>;

/// Returns a confinement that allows the parts of the machine that every program of this project needs: libraries,
/// OpenCL and GL drivers and their caches, which are created if missing. It allows little of /etc, no other users'
/// homes and no temporary folder.
Confinement system_confinement(const Variables& variable);

/// Returns the entry of `allowed` that contains `path`, which need not exist; "" if there is none. Follows links.
std::string part_that_holds(const Confinement& allowed, const std::string& path);

/// Returns whether the kernel can confine threads (Linux 5.13 and later, if enabled).
bool can_confine();

/// Confines this thread, and everything that it starts, to `allowed` from now on. Returns false if the kernel cannot.
/// Throws Error(kEnvironment) when the kernel refuses.
bool confine_this_thread(const Confinement& allowed);

}  // namespace multum
