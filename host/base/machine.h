// SPDX-License-Identifier: Apache-2.0
// What the machine has.
#pragma once

#include <cstdint>

namespace multum {

/// Bytes of physical memory.
std::uint64_t machine_memory_bytes();

}  // namespace multum
