// SPDX-License-Identifier: Apache-2.0
// Decodes binary symbols of given probabilities from the bytes of RangeEncoder, a 32-bit range coder with carries
// (Martin 1979). The decoder never reads beyond the end of the bytes. After the end, it returns correct symbols as long
// as these do not depend on the missing bytes. Then it returns zeros, and exhausted() returns true. Every prefix of a
// stream therefore decodes to a prefix of its symbols.
#pragma once

#include <cstdint>
#include <span>

namespace multum {

class RangeDecoder {
 public:
  /// The bytes must outlive the decoder.
  explicit RangeDecoder(std::span<const std::uint8_t> bytes);

  /// Returns the next symbol. `probability` is the probability of a 1, in units of 1/65536, from 1 to 65535. Returns
  /// false once the bytes do not determine the symbol any more.
  bool decode(std::uint32_t probability) {
    if (exhausted_) return false;
    // The size of the part of the interval that stands for 1. This part is at the beginning of the interval.
    const std::uint32_t bound = (range_ >> 16) * probability;
    // Untrusted bytes may give a number beyond the interval. Such a number is replaced by the last number in the
    // interval.
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

  /// Returns whether a symbol was requested that the bytes did not determine.
  bool exhausted() const { return exhausted_; }

 private:
  void take_byte();

  std::span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
  std::uint32_t range_ = 0xffffffff;
  std::uint32_t code_ = 0;     // offset of the stream's number from the interval's start; missing bytes are zeros
  std::uint32_t unknown_ = 0;  // the largest number that missing bytes could add
  bool exhausted_ = false;
};

}  // namespace multum
