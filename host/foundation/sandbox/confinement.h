// SPDX-License-Identifier: Apache-2.0
// Blocks a process from files that it does not need, with Linux's Landlock. The system then opens only allowed files,
// no matter which path, link or library the process and its children use. Newer kernels also block TCP (6.7), and
// signals to processes outside the confinement (6.12). Landlock needs no privilege and cannot be undone.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace multum {

struct Confinement {
  /// Files, or folders with their contents. Missing files and folders are skipped.
  std::vector<std::string> readable, writable;
};

/// Returns the value of an environment variable, or "" if it is not set.
using Variables = std::function<std::string(const char* name)>;

/// Returns a confinement that allows the parts of the machine that every program of this project needs. These are
/// libraries, and OpenCL and GL drivers and their caches, which are created if missing. The confinement allows only a
/// few files of /etc. It does not allow homes of other users or temporary folders.
Confinement system_confinement(const Variables& variable);

/// Returns the entry of `allowed` that contains `path`, or "" if there is none. `path` need not exist. Follows links.
std::string part_that_holds(const Confinement& allowed, const std::string& path);

/// Returns whether the kernel can confine threads (Linux 5.13 and later, if enabled).
bool can_confine();

/// Confines this thread, and everything that it starts, to `allowed` from now on. Returns false if the kernel cannot do
/// this. Throws Error(kEnvironment) if the kernel reports an error.
bool confine_this_thread(const Confinement& allowed);

}  // namespace multum
