// SPDX-License-Identifier: Apache-2.0
// Describes the machine, and tunes the program's use of memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace multum {

struct ContainerLimits;

/// Returns the path of the running program, with all links resolved, or "" if the system does not report it.
std::string own_program();

/// Returns the largest number of bytes of memory that this process can have. This is the memory of the machine, or a
/// lower limit of the container (control groups, host/foundation/base/processes/container_limits.h) or of the process
/// (ulimit -v and -d). The value is determined at the first call.
std::uint64_t machine_memory_bytes();

/// Returns the number of threads that can run at once, at least 1. This is the number of processors that this process
/// may use (its affinity, which a container's cpuset also limits). If the container's quota of processor time is lower,
/// the result is the quota, rounded up. The number is determined at the first call.
int processor_count();
/// Like processor_count(), but computes the number again, with the given limits of a container.
int processor_count(const ContainerLimits& limits);

/// Asks the system for large pages before many megabytes of memory are used for the first time. If the system grants
/// pages of 2 MB, there are 512 times fewer page faults. The request is only a hint to the system.
void prefer_large_pages(void* memory, std::size_t bytes);

/// Keeps freed blocks of up to 32 MB for later allocations, up to 64 MB in all. Otherwise the C library would return
/// each block to the system, and the system would clear the pages of the next block. For a bake in bands, which often
/// allocates and frees blocks, this would take 4 % of the time. Call this function from main().
void keep_freed_memory();

}  // namespace multum
