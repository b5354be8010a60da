// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/block_encoder.h"

#include <algorithm>
#include <cmath>

#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"
#include "kernels/shared/block_encoding.h"

namespace multum {
namespace {

constexpr int kSide = 4;

// Returns the number of channels per block. Each channel has 16 consecutive values.
int value_channels(TexelFormat format) {
  switch (format) {
    case TexelFormat::kBc4: return 1;
    case TexelFormat::kBc5: return 2;
    case TexelFormat::kBc7: return 3;
    default: break;
  }
  MULTUM_CHECK(false);
}

}  // namespace

std::vector<std::uint8_t> BlockEncoder::encode(TexelFormat format, int width, int row_count,
                                               const std::vector<glm::vec4>& texels, BlockColour colour) {
  MULTUM_CHECK(texels.size() == size_of(width) * size_of(row_count) && !texels.empty());
  const bool has_colours = format == TexelFormat::kBc7, has_mask = has_colours && colour == BlockColour::kRga;
  const int channels = value_channels(format), columns = (width + kSide - 1) / kSide;
  const int rows = (row_count + kSide - 1) / kSide;
  const std::size_t count = size_of(columns) * size_of(rows);
  const std::size_t value_bytes = count * size_of(channels) * MULTUM_BLOCK_TEXELS * sizeof(float);
  const std::size_t bytes = count * size_of(info_of(format).block_bytes);
  if (values_.byte_count() < value_bytes) values_ = device_.make_buffer(value_bytes, "texels of blocks");
  if (blocks_.byte_count() < bytes) blocks_ = device_.make_buffer(bytes, "encoded blocks");
  device_.write_ranges({{&values_, 0, value_bytes}}, [&](const Device::Bytes& at) {
    auto* to = reinterpret_cast<float*>(at[0]);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < columns; ++x)
        for (int c = 0; c < channels; ++c) {
          const int source = has_mask && c == 2 ? 3 : c;
          for (int i = 0; i < MULTUM_BLOCK_TEXELS; ++i) {
            const int row = std::min(kSide * y + i / kSide, row_count - 1);
            const int column = std::min(kSide * x + i % kSide, width - 1);
            *to++ = 255.0f * std::clamp(texels[size_of(row) * size_of(width) + size_of(column)][source], 0.0f, 1.0f);
          }
        }
  });
  Kernel& kernel = has_colours ? colour_ : scalar_;
  if (!kernel.is_built())
    kernel =
        device_.kernel("block_encoding", has_colours ? "encode_colour_blocks" : "encode_scalar_blocks", {1, 1, false});
  const std::size_t items = format == TexelFormat::kBc5 ? 2 * count : count;
  if (has_colours) kernel.launch({items}, values_, blocks_, static_cast<int>(items), has_mask ? 1 : 0);
  else kernel.launch({items}, values_, blocks_, static_cast<int>(items));
  std::vector<std::uint8_t> encoded(bytes);
  device_.read(blocks_, encoded.data(), bytes);
  return encoded;
}

}  // namespace multum
