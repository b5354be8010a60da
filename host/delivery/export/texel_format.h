// SPDX-License-Identifier: Apache-2.0
// Lists the texel formats of texture files, and computes the number of bytes of levels. The data is linear and consists
// of single texels or of blocks of 4 x 4 texels.
#pragma once

#include <cstddef>
#include <cstdint>

namespace multum {

enum class TexelFormat { kR8, kRg8, kRgba8, kRgba16f, kBc4, kBc5, kBc7, kUastc, kUastcAlpha };

struct TexelFormatInfo {
  const char* name;           // common name, such as "RG8"
  std::uint32_t vk_format;    // VkFormat; 0 if there is none
  std::uint32_t dxgi_format;  // DXGI_FORMAT; 0 if there is none
  int channels;
  int block_side;   // 1 or 4 texels
  int block_bytes;  // bytes per texel if the block side is 1
  int type_bytes;   // bytes of a texel's number type; 1 for blocks
  bool is_float;
};

const TexelFormatInfo& info_of(TexelFormat format);

/// A 2D texture, or an array of 2D textures. Each level has half the sides of the previous one, rounded down.
struct LeveledTexture {
  TexelFormat format = TexelFormat::kRgba8;
  int width = 1, height = 1;
  int level_count = 1;
  int layer_count = 0;         // 0 if the texture is not an array
  bool alpha_is_data = false;  // true if the fourth channel is data, not opacity
};

/// Returns the number of rows of blocks of a level, in all layers of an array together. A block may be a single texel.
int block_rows(const LeveledTexture& texture, int level);
std::uint64_t block_row_bytes(const LeveledTexture& texture, int level);
std::uint64_t level_bytes(const LeveledTexture& texture, int level);

}  // namespace multum
