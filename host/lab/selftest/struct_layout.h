// SPDX-License-Identifier: Apache-2.0
// Checks that host and device use the same layout for the structs in kernels/shared.
#pragma once

#include <vector>

#include "host/formats/opencl/device.h"

namespace multum {

/// Returns sizes and offsets in bytes, in the order of probe_layout (kernels/probe_numerics.cl). A value that the
/// device does not know is -1.
struct StructLayout {
  std::vector<int> host, device;
};
StructLayout struct_layout(Device& device);

}  // namespace multum
