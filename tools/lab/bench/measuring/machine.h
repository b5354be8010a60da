// SPDX-License-Identifier: Apache-2.0
// Describes the machine on which a table of figures was measured.
#pragma once

#include <cstdint>
#include <string>

namespace multum::bench {

std::string processor_name();
std::string system_name();  // such as "Debian GNU/Linux 12 (bookworm)"
int core_count();           // number of cores that this process can use
std::uint64_t memory_bytes();

/// Names the folder's file system, such as "ext4" or "tmpfs". If the name is unknown, returns its number in
/// hexadecimal.
std::string file_system_name(const std::string& folder);

}  // namespace multum::bench
