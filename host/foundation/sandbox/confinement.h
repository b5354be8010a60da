// SPDX-License-Identifier: Apache-2.0
// Shuts a process off from files that it has no use for, by Linux's Landlock: whatever path, link or library it follows
// later, the system opens nothing else for it or its children. Newer kernels shut it off from TCP (6.7) and from
// sending signals to processes that are not confined with it (6.12) too. It needs no privilege, and there is no way
// back.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace multum {

struct Confinement {
  /// Files, or folders with all in them; those that are not there are passed over.
  std::vector<std::string> readable, writable;
};

/// An environment variable's value; "": not set.
using Variables = std::function<std::string(const char* name)>;

/// Confinement that leaves what every program of this project needs of a machine: libraries, drivers of OpenCL and GL
/// and their caches, which are made if need be; little of /etc, nothing of others' homes, no temporary folder.
Confinement system_confinement(const Variables& variable);

/// The part of it that holds `path`, which may not be there; "": none does. Links are followed.
std::string part_that_holds(const Confinement& allowed, const std::string& path);

/// Can the kernel confine threads (Linux 5.13 and later, if it is switched on)?
bool can_confine();

/// Confines this thread, and what it starts, to these alone from here on. False: the kernel cannot. Throws
/// Error(kEnvironment) when it refuses.
bool confine_this_thread(const Confinement& allowed);

}  // namespace multum
