// SPDX-License-Identifier: Apache-2.0
// Tells network file systems and user-space (FUSE) file systems from local disks. A ledger must not be on such file
// systems, because their locks and their order of writes are not reliable enough for SQLite. Two daemons could both
// believe that they own the ledger.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

/// Returns the name of a network or FUSE file system, such as "NFS", for a value of f_type from statfs(). Returns ""
/// for a local disk or an unknown type.
std::string network_disk_name(std::int64_t type);

/// Throws Error(kEnvironment), which names the file system, when the folder is not on a local disk.
void check_is_local(const std::string& folder);

}  // namespace multum
