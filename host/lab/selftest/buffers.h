// SPDX-License-Identifier: Apache-2.0
// Copies lists to the buffers of a device and back. Private to host/lab/selftest.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "host/formats/opencl/device.h"

namespace multum {

/// Fills outputs of kernels before a launch, so that unwritten values are visible.
constexpr float kPoison = std::numeric_limits<float>::quiet_NaN();

template <typename Element>
DeviceBuffer uploaded(Device& device, const std::vector<Element>& list, const std::string& what) {
  DeviceBuffer buffer = device.make_buffer(list.size() * sizeof(Element), what);
  if (!list.empty()) device.write(buffer, list.data(), buffer.byte_count());
  return buffer;
}

template <typename Element>
std::vector<Element> downloaded(Device& device, const DeviceBuffer& buffer) {
  std::vector<Element> list(buffer.byte_count() / sizeof(Element));
  device.read(buffer, list.data(), buffer.byte_count());
  return list;
}

}  // namespace multum
