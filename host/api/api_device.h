// SPDX-License-Identifier: Apache-2.0
// The handle of a device in multum.h.
#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "host/api/multum.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

struct multum_device {
  multum::Device device;
  std::string name;
  std::timed_mutex mutex;  // held by a call that uses the device
  std::atomic<std::thread::id> user = {};
};

namespace multum {

/// Uses a device during the object's life. Waits until other calls have finished, and reports the wait as progress, so
/// that it can be cancelled.
class DeviceUse {
 public:
  /// Throws Cancelled, and Error(kUsage) if a callback of a call that uses the device makes this call.
  DeviceUse(multum_device& device, Progress* progress);
  ~DeviceUse();
  DeviceUse(const DeviceUse&) = delete;
  DeviceUse& operator=(const DeviceUse&) = delete;

 private:
  multum_device& device_;
};

}  // namespace multum
