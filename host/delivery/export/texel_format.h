// SPDX-License-Identifier: Apache-2.0
// Formats of texels in files of textures, and the bytes that levels take: linear data, one texel or a block of 4 x 4 at
// a time.
#pragma once

#include <cstddef>
#include <cstdint>

namespace multum {

enum class TexelFormat { kR8, kRg8, kRgba8, kRgba16f, kBc4, kBc5, kBc7, kUastc, kUastcAlpha };

struct TexelFormatInfo {
  const char* name;           // "RG8", as people say it
  std::uint32_t vk_format;    // VkFormat; 0: it has none
  std::uint32_t dxgi_format;  // DXGI_FORMAT; the same
  int channels;
  int block_side;   // texels: 1 or 4
  int block_bytes;  // of a texel where the side is 1
  int type_bytes;   // of the number that texels are made of; 1 for blocks
  bool is_float;
};

const TexelFormatInfo& info_of(TexelFormat format);

/// A 2D texture, or an array of them, with levels whose sides are halved and rounded down.
struct LeveledTexture {
  TexelFormat format = TexelFormat::kRgba8;
  int width = 1, height = 1;
  int level_count = 1;
  int layer_count = 0;         // 0: no array
  bool alpha_is_data = false;  // of four channels: a value like the others, no opacity
};

/// Rows of blocks of a level, of an array those of all layers, and bytes of one; of texels where blocks are texels.
int block_rows(const LeveledTexture& texture, int level);
std::uint64_t block_row_bytes(const LeveledTexture& texture, int level);
std::uint64_t level_bytes(const LeveledTexture& texture, int level);

}  // namespace multum
