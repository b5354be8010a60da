// SPDX-License-Identifier: Apache-2.0
// The device that tests run kernels on.
#pragma once

#include "host/formats/opencl/device.h"

namespace multum::testing {

/// The first, a CPU where tests are run; one for the whole program, so that kernels are built once.
inline Device& test_device() {
  // Never closed: a simulator preloaded into the process (oclgrind) is gone before the program's own statics are.
  static Device& device = *new Device(Device::open(""));
  return device;
}

}  // namespace multum::testing
