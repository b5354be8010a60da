// SPDX-License-Identifier: Apache-2.0
// Reads the limits that a container sets by Linux control groups of version 1, version 2 or both. The limits of a group
// and of all groups above it apply, so the smallest of these limits counts.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

namespace multum {

struct ContainerLimits {
  static constexpr std::uint64_t kNoMemoryLimit = std::numeric_limits<std::uint64_t>::max();

  std::uint64_t memory_bytes = kNoMemoryLimit;
  double processors = std::numeric_limits<double>::infinity();  // processor seconds per second of wall time
};

/// Returns the limits of this process. For memory, these are memory.max, memory.high, memory.limit_in_bytes, and
/// hierarchical_memory_limit of memory.stat. For processors, these are cpu.max, cpu.cfs_quota_us and cpu.cfs_period_us.
/// Groups are found through ROOT/proc/self/cgroup and ROOT/proc/self/mountinfo, and always at ROOT/sys/fs/cgroup. Only
/// tests set `root`. A value that is missing or not a number is ignored.
ContainerLimits container_limits(const std::string& root);

}  // namespace multum
