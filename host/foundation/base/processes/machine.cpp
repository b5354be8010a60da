// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/processes/machine.h"

#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <memory>
#include <thread>

#include "host/foundation/base/processes/container_limits.h"

namespace multum {
namespace {

const ContainerLimits& limits_here() {
  static const ContainerLimits limits = container_limits("");
  return limits;
}

std::uint64_t process_limit(__rlimit_resource which) {
  rlimit limit = {};
  return ::getrlimit(which, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY ? ContainerLimits::kNoMemoryLimit
                                                                            : limit.rlim_cur;
}

// The kernel rejects a processor set that is smaller than its own, and does not report the required size.
int affinity_count() {
  for (int room = 1024; room <= (1 << 20); room *= 2) {
    const std::unique_ptr<cpu_set_t, void (*)(cpu_set_t*)> set(CPU_ALLOC(static_cast<std::size_t>(room)),
                                                               [](cpu_set_t* s) { CPU_FREE(s); });
    if (set == nullptr) break;
    const std::size_t bytes = CPU_ALLOC_SIZE(static_cast<std::size_t>(room));
    if (::sched_getaffinity(0, bytes, set.get()) == 0) return CPU_COUNT_S(bytes, set.get());
    if (errno != EINVAL) break;
  }
  return static_cast<int>(std::thread::hardware_concurrency());
}

}  // namespace

std::string own_program() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).string();
}

std::uint64_t machine_memory_bytes() {
  static const std::uint64_t bytes =
      std::min({static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)),
                limits_here().memory_bytes, process_limit(RLIMIT_AS), process_limit(RLIMIT_DATA)});
  return bytes;
}

int processor_count() {
  static const int count = processor_count(limits_here());
  return count;
}

int processor_count(const ContainerLimits& limits) {
  const int allowed = std::max(1, affinity_count());
  const double quota = std::ceil(limits.processors);
  return quota < allowed ? std::max(1, static_cast<int>(quota)) : allowed;
}

void prefer_large_pages(void* memory, std::size_t bytes) {
  constexpr std::uintptr_t kPage = std::uintptr_t{2} << 20;
  const auto begin = (reinterpret_cast<std::uintptr_t>(memory) + kPage - 1) / kPage * kPage;
  const auto end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / kPage * kPage;
  if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
}

}  // namespace multum
