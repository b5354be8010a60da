// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/machine.h"

#include <fstream>

namespace multum::bench {
namespace {

// The rest of the first line of `path` that starts with `key`, after `separator`, without quotes.
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

}  // namespace multum::bench
