// SPDX-License-Identifier: Apache-2.0
// A line of /proc/self/cgroup names a hierarchy and this process's group in it. A line of /proc/self/mountinfo names
// the folder where the groups of a hierarchy are visible, and the topmost visible group (cgroups(7), proc(5)):
//
//   4:memory:/docker/a1/b           0::/user.slice
//   35 31 0:32 /docker/a1 /sys/fs/cgroup/memory rw,relatime - cgroup cgroup rw,memory
//
// In this example, group /docker/a1/b is the folder /sys/fs/cgroup/memory/b.
#include "host/foundation/base/processes/container_limits.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

namespace multum {
namespace {

namespace fs = std::filesystem;

// A hierarchy. In version 2, its list of controllers is empty.
struct Hierarchy {
  std::string controllers;  // list of controllers: "cpu,cpuacct"
  std::string group;        // group of this process: "/docker/a1/b"
};

// A folder that shows a hierarchy from its group `top` downwards.
struct GroupMount {
  std::string controllers;
  std::string top, folder;
};

bool has_controller(const std::string& list, const std::string& name) {
  return ("," + list + ",").find("," + name + ",") != std::string::npos;
}

std::vector<Hierarchy> read_hierarchies(const std::string& root) {
  std::vector<Hierarchy> found;
  std::ifstream in(root + "/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    found.push_back({line.substr(first + 1, second - first - 1), line.substr(second + 1)});
  }
  return found;
}

// Replaces octal escapes, such as "\040" for a space.
std::string without_escapes(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    int value = 0;
    if (text[i] == '\\' && i + 3 < text.size() &&
        std::from_chars(text.data() + i + 1, text.data() + i + 4, value, 8).ptr == text.data() + i + 4) {
      plain += static_cast<char>(value);
      i += 3;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

std::vector<GroupMount> read_mounts(const std::string& root) {
  std::vector<GroupMount> found;
  std::ifstream in(root + "/proc/self/mountinfo");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string number, parent, device, top, folder, word, type, source, options;
    words >> number >> parent >> device >> top >> folder;
    while (words >> word && word != "-") {  // options, and optional tags
    }
    if (!(words >> type >> source >> options) || (type != "cgroup" && type != "cgroup2")) continue;
    found.push_back({type == "cgroup2" ? "" : options, without_escapes(top), root + without_escapes(folder)});
  }
  // The usual place of control groups. A container may also make groups visible at this place.
  found.push_back({"", "/", root + "/sys/fs/cgroup"});
  return found;
}

// Returns the visible folders of the group and of the groups above it.
std::vector<std::string> folders_of(const GroupMount& mount, const std::string& group) {
  fs::path below = fs::path(group).lexically_relative(mount.top);
  if (below.empty() || below == "." || *below.begin() == "..") below.clear();
  std::vector<std::string> folders;
  for (;; below = below.parent_path()) {
    folders.push_back((fs::path(mount.folder) / below).string());
    if (below.empty()) return folders;
  }
}

// Reads the first word of a file, or the next word of `in`, as a number above 0.
std::optional<std::uint64_t> read_number(std::istream& in) {
  std::string word;
  if (!(in >> word)) return std::nullopt;
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value == 0) return std::nullopt;
  return value;
}

std::optional<std::uint64_t> number_in(const std::string& path) {
  std::ifstream in(path);
  return read_number(in);
}

void lower_memory(ContainerLimits& limits, std::optional<std::uint64_t> bytes) {
  if (bytes) limits.memory_bytes = std::min(limits.memory_bytes, *bytes);
}

void lower_processors(ContainerLimits& limits, std::optional<std::uint64_t> quota,
                      std::optional<std::uint64_t> period) {
  if (quota && period)
    limits.processors = std::min(limits.processors, static_cast<double>(*quota) / static_cast<double>(*period));
}

void read_version_2(const std::string& folder, ContainerLimits& limits) {
  lower_memory(limits, number_in(folder + "/memory.max"));
  lower_memory(limits, number_in(folder + "/memory.high"));
  std::ifstream in(folder + "/cpu.max");
  const std::optional<std::uint64_t> quota = read_number(in);
  lower_processors(limits, quota, quota ? read_number(in) : std::nullopt);
}

void read_version_1(const std::string& folder, const std::string& controllers, ContainerLimits& limits) {
  if (has_controller(controllers, "memory")) {
    lower_memory(limits, number_in(folder + "/memory.limit_in_bytes"));
    std::ifstream in(folder + "/memory.stat");  // includes limits of parent groups that a container does not see
    for (std::string name; in >> name;)
      if (name == "hierarchical_memory_limit") lower_memory(limits, read_number(in));
  }
  if (has_controller(controllers, "cpu"))
    lower_processors(limits, number_in(folder + "/cpu.cfs_quota_us"), number_in(folder + "/cpu.cfs_period_us"));
}

}  // namespace

ContainerLimits container_limits(const std::string& root) {
  ContainerLimits limits;
  const std::vector<Hierarchy> hierarchies = read_hierarchies(root);
  for (const GroupMount& mount : read_mounts(root))
    for (const Hierarchy& hierarchy : hierarchies) {
      const bool is_version_2 = hierarchy.controllers.empty();
      if (is_version_2 != mount.controllers.empty()) continue;
      for (const std::string& folder : folders_of(mount, hierarchy.group)) {
        if (is_version_2) read_version_2(folder, limits);
        else if (has_controller(mount.controllers, hierarchy.controllers.substr(0, hierarchy.controllers.find(','))))
          read_version_1(folder, hierarchy.controllers, limits);
      }
    }
  return limits;
}

}  // namespace multum
