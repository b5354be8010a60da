// SPDX-License-Identifier: Apache-2.0
// Writes binary symbols of given probabilities as bytes that RangeDecoder reads. The encoder is a 32-bit range coder
// (Martin 1979) that carries into bytes already written.
#pragma once

#include <cstdint>
#include <vector>

namespace multum {

class RangeEncoder {
 public:
  /// `probability` is the probability of a 1, in units of 1/65536, from 1 to 65535.
  void encode(bool bit, std::uint32_t probability);

  /// Returns the number of bits of the symbols so far, with an error of at most 32 bits.
  std::size_t bits() const { return 8 * bytes_.size(); }

  /// Returns the fewest bytes that determine every symbol, regardless of the bytes that follow. Resets the encoder.
  std::vector<std::uint8_t> finish();

 private:
  void shift_byte();
  void carry();

  std::vector<std::uint8_t> bytes_;
  std::uint64_t low_ = 0;  // start of the interval, below the bytes in `bytes_`; bit 32 is a carry
  std::uint32_t range_ = 0xffffffff;
};

}  // namespace multum
