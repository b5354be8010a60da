// SPDX-License-Identifier: Apache-2.0
// Encodes rows of texels as blocks of 4 x 4: BC4, BC5 and BC7, on an OpenCL device (kernels/block_encoding.cl).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec4.hpp>

#include "host/delivery/export/texel_format.h"
#include "host/formats/opencl/device.h"

namespace multum {

/// What BC7 stores; the fourth channel is 1.
enum class BlockColour {
  kRgb,  // red, green and blue
  kRga,  // red, green and alpha
};

class BlockEncoder {
 public:
  explicit BlockEncoder(Device& device) : device_(device) {}

  /// Rows of blocks of `texels`, row_count rows of `width`, values from 0 to 1; sides that are no multiples of 4 are
  /// filled up by repeating the last texel. BC4 takes red, BC5 red and green, BC7 what `colour` says.
  /// Throws Error(kEnvironment) when the device refuses.
  std::vector<std::uint8_t> encode(TexelFormat format, int width, int row_count, const std::vector<glm::vec4>& texels,
                                   BlockColour colour = BlockColour::kRgb);

 private:
  Device& device_;
  Kernel scalar_, colour_;
  DeviceBuffer values_, blocks_;
};

}  // namespace multum
