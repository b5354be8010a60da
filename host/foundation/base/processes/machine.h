// SPDX-License-Identifier: Apache-2.0
// Describes the machine, and tunes how a program uses its memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace multum {

struct ContainerLimits;

/// The file of the running program, without links; "" where the system does not say.
std::string own_program();
/// The folder that it lies in: programs of the same build are beside it.
std::string own_folder();

/// Bytes of memory that this process may take at most: the machine's, or less where limits of a container (control
/// groups, host/foundation/base/processes/container_limits.h) or of the process (ulimit -v and -d) say so. As it was
/// when first asked.
std::uint64_t machine_memory_bytes();

/// Number of threads that can run at once, at least 1: processors that this process may use (its affinity, which the
/// cpuset of a container limits too), or fewer where a container's quota of processor time is less, rounded up. As it
/// was when first asked.
int processor_count();
/// The same under these limits of a container, asked anew.
int processor_count(const ContainerLimits& limits);

/// Asks for large pages, before memory of many megabytes is touched for the first time: pages of 2 MB, where the system
/// grants them on demand, are a 512th of the page faults. A hint.
void prefer_large_pages(void* memory, std::size_t bytes);

/// Keeps freed blocks of up to 32 MB for the next that ask, up to 64 MB in all, where the C library would give each
/// back to the system and have the next one's pages cleared: 4 % of a bake in bands, whose blocks come and go. For
/// main().
void keep_freed_memory();

}  // namespace multum
