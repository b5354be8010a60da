// SPDX-License-Identifier: Apache-2.0
// Counts what a device does for one job. A process uses a device for many, and Device counts from its opening on.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "host/formats/opencl/device.h"

namespace multum {

class DeviceCounts {
 public:
  /// From now on. A device that is not open yet stays so.
  explicit DeviceCounts(Device& device);

  /// By kernel, without those that were not launched.
  std::map<std::string, std::uint64_t> launches() const;
  /// Of programs, by kernels/FILE.cl: built, or taken from the cache.
  std::map<std::string, int> builds() const;
  /// On the device, by kernel, of launches that were timed. Waits for all launches.
  std::map<std::string, double> launch_seconds() const;
  TransferCounts transfers() const;

 private:
  Device& device_;
  std::map<std::string, std::uint64_t> launches_before_;
  std::map<std::string, int> builds_before_;
  std::map<std::string, double> seconds_before_;
  TransferCounts transfers_before_;
};

}  // namespace multum
