// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/block_decoding.h"

#include <algorithm>
#include <utility>

#include "host/formats/asset/textures/scalar_block.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"
#include "kernels/shared/block_encoding.h"

namespace multum {
namespace {

// Reads bits, beginning with the lowest bit of the first byte.
class BitReader {
 public:
  explicit BitReader(const std::uint8_t* bytes) : bytes_(bytes) {}
  int take(int count) {
    int value = 0;
    for (int i = 0; i < count; ++i, ++at_) value |= (bytes_[at_ / 8] >> (at_ % 8) & 1) << i;
    return value;
  }

 private:
  const std::uint8_t* bytes_;
  int at_ = 0;
};

constexpr unsigned kPartitionMasks[] = MULTUM_BC7_PARTITION_MASKS;
constexpr int kAnchors[] = MULTUM_BC7_ANCHORS;

// Returns the interpolation weight of an index, in 64ths.
int index_weight(int index, int bit_count) {
  static constexpr int kTwo[] = {0, 21, 43, 64};
  static constexpr int kThree[] = {0, 9, 18, 27, 37, 46, 55, 64};
  static constexpr int kFour[] = {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64};
  return (bit_count == 2 ? kTwo : bit_count == 3 ? kThree : kFour)[index];
}

int interpolated(int low, int high, int weight) { return ((64 - weight) * low + weight * high + 32) >> 6; }

// Widens a value to 8 bits by repeating its highest bits.
int widened(int value, int bit_count) { return (value << (8 - bit_count)) | (value >> (2 * bit_count - 8)); }

using Indices = std::array<int, 16>;

Indices take_indices(BitReader& bits, int bit_count, int other_anchor) {
  Indices indices{};
  for (int i = 0; i < 16; ++i) indices[size_of(i)] = bits.take(i == 0 || i == other_anchor ? bit_count - 1 : bit_count);
  return indices;
}

struct Bc7Ends {
  int channels[4][4];  // [channel][endpoint]; the endpoints of line 0, then those of line 1
};

Bc7Ends take_ends(BitReader& bits, int end_count, int colour_bits, int alpha_bits) {
  Bc7Ends ends{};
  for (int c = 0; c < 4; ++c)
    for (int e = 0; e < end_count; ++e)
      ends.channels[c][e] = c < 3 ? bits.take(colour_bits) : alpha_bits > 0 ? bits.take(alpha_bits) : 255;
  return ends;
}

glm::vec4 share_of(const int (&codes)[4]) {
  return glm::vec4(static_cast<float>(codes[0]), static_cast<float>(codes[1]), static_cast<float>(codes[2]),
                   static_cast<float>(codes[3])) /
         255.0f;
}

BlockTexels decode_mode_6(BitReader& bits) {
  Bc7Ends ends = take_ends(bits, 2, 7, 7);
  const int p[2] = {bits.take(1), bits.take(1)};
  for (auto& channel : ends.channels)
    for (int e = 0; e < 2; ++e) channel[e] = channel[e] << 1 | p[e];
  const Indices indices = take_indices(bits, 4, -1);
  BlockTexels texels;
  for (std::size_t i = 0; i < 16; ++i) {
    int codes[4];
    for (int c = 0; c < 4; ++c)
      codes[c] = interpolated(ends.channels[c][0], ends.channels[c][1], index_weight(indices[i], 4));
    texels[i] = share_of(codes);
  }
  return texels;
}

BlockTexels decode_separate(BitReader& bits, int mode) {
  const int colour_bits = mode == 4 ? 5 : 7, alpha_bits = mode == 4 ? 6 : 8;
  const int rotation = bits.take(2);
  const bool colours_are_finer = mode == 4 && bits.take(1) == 1;
  Bc7Ends ends = take_ends(bits, 2, colour_bits, alpha_bits);
  for (int c = 0; c < 4; ++c)
    for (int e = 0; e < 2; ++e) ends.channels[c][e] = widened(ends.channels[c][e], c < 3 ? colour_bits : alpha_bits);
  const int second_bits = mode == 4 ? 3 : 2;
  const Indices first = take_indices(bits, 2, -1), second = take_indices(bits, second_bits, -1);
  BlockTexels texels;
  for (std::size_t i = 0; i < 16; ++i) {
    int codes[4];
    for (int c = 0; c < 4; ++c) {
      const bool takes_second = (c == 3) != colours_are_finer;
      const int weight = takes_second ? index_weight(second[i], second_bits) : index_weight(first[i], 2);
      codes[c] = interpolated(ends.channels[c][0], ends.channels[c][1], weight);
    }
    if (rotation > 0) std::swap(codes[3], codes[rotation - 1]);
    texels[i] = share_of(codes);
  }
  return texels;
}

BlockTexels decode_mode_1(BitReader& bits) {
  const auto partition = size_of(bits.take(6));
  Bc7Ends ends = take_ends(bits, 4, 6, 0);
  const int p[2] = {bits.take(1), bits.take(1)};
  for (int c = 0; c < 3; ++c)
    for (int e = 0; e < 4; ++e) ends.channels[c][e] = widened(ends.channels[c][e] << 1 | p[e / 2], 7);
  const Indices indices = take_indices(bits, 3, kAnchors[partition]);
  BlockTexels texels;
  for (std::size_t i = 0; i < 16; ++i) {
    const int line = static_cast<int>(kPartitionMasks[partition] >> i & 1u);
    int codes[4];
    for (int c = 0; c < 4; ++c)
      codes[c] = interpolated(ends.channels[c][2 * line], ends.channels[c][2 * line + 1], index_weight(indices[i], 3));
    texels[i] = share_of(codes);
  }
  return texels;
}

BlockTexels decode_bc7(const std::uint8_t* block) {
  BitReader bits(block);
  int mode = 0;
  while (mode < 8 && bits.take(1) == 0) ++mode;
  if (mode == 1) return decode_mode_1(bits);
  if (mode == 4 || mode == 5) return decode_separate(bits, mode);
  MULTUM_CHECK(mode == 6);
  return decode_mode_6(bits);
}

}  // namespace

BlockTexels decode_block(TexelFormat format, const std::uint8_t* block) {
  if (format == TexelFormat::kBc7) return decode_bc7(block);
  MULTUM_CHECK(format == TexelFormat::kBc4 || format == TexelFormat::kBc5);
  const std::array<float, 16> red = decode_scalar_block(block);
  const std::array<float, 16> green =
      format == TexelFormat::kBc5 ? decode_scalar_block(block + 8) : std::array<float, 16>{};
  BlockTexels texels;
  for (std::size_t i = 0; i < 16; ++i) texels[i] = {red[i], green[i], 0.0f, 1.0f};
  return texels;
}

}  // namespace multum
