// SPDX-License-Identifier: Apache-2.0
// The handle of a device in multum.h.
#pragma once

#include <mutex>
#include <string>

#include "host/api/multum.h"
#include "host/formats/opencl/device.h"

struct multum_device {
  multum::Device device;
  std::string name;
  std::mutex mutex;  // held by a call that uses the device
};
