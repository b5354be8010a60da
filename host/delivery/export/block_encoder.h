// SPDX-License-Identifier: Apache-2.0
// Encodes rows of texels as blocks of 4 x 4 texels (BC4, BC5 and BC7) on an OpenCL device (kernels/block_encoding.cl).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec4.hpp>

#include "host/delivery/export/texel_format.h"
#include "host/formats/opencl/device.h"

namespace multum {

/// The channels that BC7 stores. The fourth channel is 1.
enum class BlockColour {
  kRgb,  // red, green and blue
  kRga,  // red, green and alpha
};

class BlockEncoder {
 public:
  explicit BlockEncoder(Device& device) : device_(device) {}

  /// Encodes `texels`, row_count rows of `width` values from 0 to 1, as rows of blocks. Sides that are not multiples of
  /// 4 are padded with the last texel. BC4 stores red, BC5 stores red and green, and BC7 stores the channels of
  /// `colour`. Throws Error(kEnvironment) if the device fails.
  std::vector<std::uint8_t> encode(TexelFormat format, int width, int row_count, const std::vector<glm::vec4>& texels,
                                   BlockColour colour = BlockColour::kRgb);

 private:
  Device& device_;
  Kernel scalar_, colour_;
  DeviceBuffer values_, blocks_;
};

}  // namespace multum
