// SPDX-License-Identifier: Apache-2.0
// Reads what a container leaves of its machine: limits of Linux's control groups, versions 1 and 2 and both together.
// A group is held to its own limits and to those of all groups above it: the least counts.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

namespace multum {

struct ContainerLimits {
  static constexpr std::uint64_t kNoMemoryLimit = std::numeric_limits<std::uint64_t>::max();

  std::uint64_t memory_bytes = kNoMemoryLimit;
  double processors = std::numeric_limits<double>::infinity();  // processor seconds a second
};

/// Limits of this process: memory.max and memory.high, memory.limit_in_bytes and hierarchical_memory_limit of
/// memory.stat; cpu.max, cpu.cfs_quota_us and cpu.cfs_period_us. Groups are found by ROOT/proc/self/cgroup and
/// ROOT/proc/self/mountinfo, and at ROOT/sys/fs/cgroup whatever the latter says; `root` is empty but for tests. What is
/// not there or no number is no limit.
ContainerLimits container_limits(const std::string& root);

}  // namespace multum
