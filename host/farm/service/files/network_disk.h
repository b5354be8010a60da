// SPDX-License-Identifier: Apache-2.0
// Tells file systems on a network, and those of programs, from disks of this machine. A ledger in SQLite lies on none
// of them: locks and the order of writes are not kept there as it needs them, and two daemons could each believe to be
// alone.
#pragma once

#include <cstdint>
#include <string>

namespace multum {

/// "NFS", by the number that statfs() has for it (its f_type); "": a disk of this machine, or not known.
std::string network_disk_name(std::int64_t type);

/// Throws Error(kEnvironment) when the folder lies on such a file system, naming it.
void check_is_local(const std::string& folder);

}  // namespace multum
