// SPDX-License-Identifier: Apache-2.0
// Writes binary symbols of given probabilities as bytes that RangeDecoder reads back: a range coder (Martin 1979) of 32
// bits that carries into bytes already written.
#pragma once

#include <cstdint>
#include <vector>

namespace multum {

class RangeEncoder {
 public:
  /// `probability` of 1 in 1/65536, 1 to 65535.
  void encode(bool bit, std::uint32_t probability);

  /// Bits that the symbols so far take, to within 32.
  std::size_t bits() const { return 8 * bytes_.size(); }

  /// The fewest bytes that determine every symbol, whatever follows them. The encoder starts anew.
  std::vector<std::uint8_t> finish();

 private:
  void shift_byte();
  void carry();

  std::vector<std::uint8_t> bytes_;
  std::uint64_t low_ = 0;  // begin of the interval behind `bytes_`; 2^32 is a carry
  std::uint32_t range_ = 0xffffffff;
};

}  // namespace multum
