// SPDX-License-Identifier: Apache-2.0
#include "host/formats/opencl/device_counts.h"

namespace multum {
namespace {

template <typename Count>
std::map<std::string, Count> counted_since(const std::map<std::string, Count>& before,
                                           const std::map<std::string, Count>& now) {
  std::map<std::string, Count> counts;
  for (const auto& [name, count] : now) {
    const auto earlier = before.find(name);
    const Count more = count - (earlier == before.end() ? 0 : earlier->second);
    if (more > 0) counts[name] = more;
  }
  return counts;
}

}  // namespace

DeviceCounts::DeviceCounts(Device& device) : device_(device) {
  if (!device.is_open()) return;
  launches_before_ = device.launch_counts();
  builds_before_ = device.build_counts();
  seconds_before_ = device.launch_seconds();
  transfers_before_ = device.transfers();
}

std::map<std::string, std::uint64_t> DeviceCounts::launches() const {
  if (!device_.is_open()) return {};
  return counted_since(launches_before_, device_.launch_counts());
}

std::map<std::string, int> DeviceCounts::builds() const {
  if (!device_.is_open()) return {};
  return counted_since(builds_before_, device_.build_counts());
}

std::map<std::string, double> DeviceCounts::launch_seconds() const {
  if (!device_.is_open()) return {};
  return counted_since(seconds_before_, device_.launch_seconds());
}

TransferCounts DeviceCounts::transfers() const {
  return device_.is_open() ? device_.transfers() - transfers_before_ : TransferCounts{};
}

}  // namespace multum
