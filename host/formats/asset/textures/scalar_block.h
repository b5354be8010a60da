// SPDX-License-Identifier: Apache-2.0
// Decodes a block of BC4, or half a block of BC5. The block has two endpoints of 8 bits each and 3 bits per texel
// (Khronos Data Format Specification 1.3, chapter 18).
#pragma once

#include <array>
#include <cstdint>

namespace multum {

/// Returns 16 texels row by row, as values from 0 to 1. `block` has 8 bytes.
inline std::array<float, 16> decode_scalar_block(const std::uint8_t* block) {
  const int first = block[0], second = block[1], steps = first > second ? 7 : 5;
  std::uint64_t indices = 0;
  for (int i = 0; i < 6; ++i) indices |= std::uint64_t{block[2 + i]} << (8 * i);
  std::array<float, 16> values{};
  for (float& value : values) {
    const int index = static_cast<int>(indices & 7);
    indices >>= 3;
    if (steps == 5 && index >= 6) {
      value = index == 6 ? 0.0f : 1.0f;
      continue;
    }
    const int step = index == 0 ? 0 : index == 1 ? steps : index - 1;
    value = static_cast<float>((steps - step) * first + step * second) / (255.0f * static_cast<float>(steps));
  }
  return values;
}

}  // namespace multum
