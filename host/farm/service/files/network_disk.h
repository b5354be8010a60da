// SPDX-License-Identifier: Apache-2.0
// Distinguishes file systems on a network, and those of programs, from disks of this machine. An SQLite ledger must not
// be on them: they do not keep locks and the order of writes as SQLite needs, so two daemons could both believe that
// they have the ledger to themselves.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

/// Returns "NFS", for example, for an f_type of statfs(); "": a disk of this machine, or unknown.
std::string network_disk_name(std::int64_t type);

/// Throws Error(kEnvironment), which names the file system, when the folder is on such a file system.
void check_is_local(const std::string& folder);

}  // namespace multum
