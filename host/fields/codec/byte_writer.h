// SPDX-License-Identifier: Apache-2.0
// Writes the numbers that ByteReader reads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace multum {

class ByteWriter {
 public:
  void byte(std::uint8_t value) { bytes_.push_back(value); }
  void fixed(std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) byte(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void int16(std::int16_t value) { fixed(static_cast<std::uint16_t>(value), 2); }
  /// Writes a number below 2^63.
  void number(std::uint64_t value) {
    for (; value > 127; value >>= 7) byte(static_cast<std::uint8_t>(value | 128));
    byte(static_cast<std::uint8_t>(value));
  }
  void bytes(std::span<const std::uint8_t> values) { bytes_.insert(bytes_.end(), values.begin(), values.end()); }

  const std::vector<std::uint8_t>& written() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

}  // namespace multum
