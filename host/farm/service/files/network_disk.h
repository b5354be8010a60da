// SPDX-License-Identifier: Apache-2.0
// Distinguishes file systems on a network, and those of programs, from disks of this machine. An SQLite ledger must not
// be on such file systems: their locks and their order of writes are not reliable enough for SQLite. Two daemons could
// both believe that they own the ledger.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

/// Returns "NFS", for example, for an f_type of statfs(); "": a disk of this machine, or unknown.
std::string network_disk_name(std::int64_t type);

/// Throws Error(kEnvironment), which names the file system, when the folder is on such a file system.
void check_is_local(const std::string& folder);

}  // namespace multum
