// SPDX-License-Identifier: Apache-2.0
// Decodes binary symbols of given probabilities from bytes: a range coder (Martin 1979) with carries, of 32 bits.
// RangeEncoder writes what it reads. Reads nothing beyond its bytes: where they end, it goes on as long as the symbols
// are certain whatever would follow, then gives zeros and says so. So any prefix of a stream decodes to a prefix of its
// symbols.
#pragma once

#include <cstdint>
#include <span>

namespace multum {

class RangeDecoder {
 public:
  /// The bytes must outlive the decoder.
  explicit RangeDecoder(std::span<const std::uint8_t> bytes);

  /// The next symbol; `probability` of 1 in 1/65536, 1 to 65535. False from where the bytes no longer determine it.
  bool decode(std::uint32_t probability) {
    if (exhausted_) return false;
    const std::uint32_t bound = (range_ >> 16) * probability;  // of the part that stands for 1, at the interval's begin
    // Bytes of strangers may name a number beyond the interval; it counts as the last in it.
    if (code_ >= range_) code_ = range_ - 1;
    const bool bit = code_ < bound;
    if (bit && unknown_ >= bound - code_) {
      exhausted_ = true;
      return false;
    }
    if (bit) {
      range_ = bound;
    } else {
      code_ -= bound;
      range_ -= bound;
    }
    while (range_ < (1u << 24)) {
      range_ <<= 8;
      take_byte();
    }
    return bit;
  }

  /// A symbol was asked for that the bytes do not determine.
  bool exhausted() const { return exhausted_; }

 private:
  void take_byte();

  std::span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
  std::uint32_t range_ = 0xffffffff;
  std::uint32_t code_ = 0;     // offset of the stream's number from the interval's begin, missing bytes as zeros
  std::uint32_t unknown_ = 0;  // by how much missing bytes could raise it
  bool exhausted_ = false;
};

}  // namespace multum
