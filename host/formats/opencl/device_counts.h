// SPDX-License-Identifier: Apache-2.0
// Counts the work of a device for one job. A process uses one device for many jobs, but Device counts from the moment
// when the device is opened.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "host/formats/opencl/device.h"

namespace multum {

class DeviceCounts {
 public:
  /// Starts to count. Does not open the device.
  explicit DeviceCounts(Device& device);

  /// Returns launch counts by kernel, without counts of 0.
  std::map<std::string, std::uint64_t> launches() const;
  /// Returns programs built or loaded from the cache, by kernels/FILE.cl.
  std::map<std::string, int> builds() const;
  /// Returns the seconds on the device by kernel, for timed launches. Waits for all launches.
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
