// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/machine.h"

#include <fmt/format.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <fstream>

#include "host/foundation/base/processes/machine.h"

namespace multum::bench {
namespace {

// Finds the first line of `path` that starts with `key`, and returns its text after `separator`, without quotes.
std::string value_of(const char* path, const std::string& key, char separator) {
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(key, 0) != 0) continue;
    std::string value = line.substr(line.find(separator) + 1);
    std::erase(value, '"');
    return value.substr(value.find_first_not_of(' '));
  }
  return "unknown";
}

}  // namespace

std::string processor_name() { return value_of("/proc/cpuinfo", "model name", ':'); }
std::string system_name() { return value_of("/etc/os-release", "PRETTY_NAME", '='); }

int core_count() { return processor_count(); }

std::uint64_t memory_bytes() {
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::string file_system_name(const std::string& folder) {
  struct statfs found = {};
  if (statfs(folder.c_str(), &found) != 0) return "unknown";
  switch (static_cast<unsigned long>(found.f_type)) {  // numbers from statfs(2); ext2 and ext3 share ext4's number
    case 0xEF53: return "ext4";
    case 0x58465342: return "xfs";
    case 0x9123683E: return "btrfs";
    case 0x2FC12FC1: return "zfs";
    case 0x01021994: return "tmpfs";
    case 0x794C7630: return "overlay";
    case 0x6969: return "nfs";
    default: return fmt::format("{:#x}", static_cast<unsigned long>(found.f_type));
  }
}

}  // namespace multum::bench
