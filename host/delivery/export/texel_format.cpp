// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/texel_format.h"

#include <algorithm>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

int block_count(int texels, int side) { return (texels + side - 1) / side; }

}  // namespace

const TexelFormatInfo& info_of(TexelFormat format) {
  // VK_FORMAT_R8_UNORM, DXGI_FORMAT_R8_UNORM and so on.
  static constexpr TexelFormatInfo kR8 = {"R8", 9, 61, 1, 1, 1, 1, false};
  static constexpr TexelFormatInfo kRg8 = {"RG8", 16, 49, 2, 1, 2, 1, false};
  static constexpr TexelFormatInfo kRgba8 = {"RGBA8", 37, 28, 4, 1, 4, 1, false};
  static constexpr TexelFormatInfo kRgba16f = {"RGBA16F", 97, 10, 4, 1, 8, 2, true};
  static constexpr TexelFormatInfo kBc4 = {"BC4", 139, 80, 1, 4, 8, 1, false};
  static constexpr TexelFormatInfo kBc5 = {"BC5", 141, 83, 2, 4, 16, 1, false};
  static constexpr TexelFormatInfo kBc7 = {"BC7", 145, 98, 4, 4, 16, 1, false};
  static constexpr TexelFormatInfo kUastc = {"UASTC", 0, 0, 3, 4, 16, 1, false};
  static constexpr TexelFormatInfo kUastcAlpha = {"UASTC with alpha", 0, 0, 4, 4, 16, 1, false};
  switch (format) {
    case TexelFormat::kR8: return kR8;
    case TexelFormat::kRg8: return kRg8;
    case TexelFormat::kRgba8: return kRgba8;
    case TexelFormat::kRgba16f: return kRgba16f;
    case TexelFormat::kBc4: return kBc4;
    case TexelFormat::kBc5: return kBc5;
    case TexelFormat::kBc7: return kBc7;
    case TexelFormat::kUastc: return kUastc;
    case TexelFormat::kUastcAlpha: return kUastcAlpha;
  }
  MULTUM_CHECK(false);
}

int block_rows(const LeveledTexture& texture, int level) {
  return block_count(mip_level_size(texture.height, level), info_of(texture.format).block_side) *
         std::max(texture.layer_count, 1);
}

std::uint64_t block_row_bytes(const LeveledTexture& texture, int level) {
  const TexelFormatInfo& info = info_of(texture.format);
  return size_of(block_count(mip_level_size(texture.width, level), info.block_side)) * size_of(info.block_bytes);
}

std::uint64_t level_bytes(const LeveledTexture& texture, int level) {
  return block_row_bytes(texture, level) * size_of(block_rows(texture, level));
}

}  // namespace multum
