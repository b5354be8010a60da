// SPDX-License-Identifier: Apache-2.0
// The head of a texture file, which consists of all bytes before the levels, and the offsets of the levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "host/delivery/export/texel_format.h"

namespace multum {

struct TextureHead {
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint64_t> level_offsets;  // level 0 first
};

/// Appends little-endian numbers.
class ByteList {
 public:
  void add(std::uint64_t value, int byte_count) {
    for (int i = 0; i < byte_count; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void add_text(std::string_view text) {
    bytes.insert(bytes.end(), text.begin(), text.end());
    bytes.push_back(0);
  }
  void pad_to(std::size_t multiple) {
    while (bytes.size() % multiple != 0) bytes.push_back(0);
  }
  std::vector<std::uint8_t> bytes;
};

}  // namespace multum
