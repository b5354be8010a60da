// SPDX-License-Identifier: Apache-2.0
// Writes binary symbols of given probabilities as bytes that RangeDecoder reads: a 32-bit range coder (Martin 1979)
// that carries into bytes already written.
#pragma once

#include <cstdint>
#include <vector>

namespace multum {

class RangeEncoder {
 public:
  /// `probability`: of 1, in 1/65536, 1 to 65535.
  void encode(bool bit, std::uint32_t probability);

  /// Returns the bits of the symbols so far, to within 32 bits.
  std::size_t bits() const { return 8 * bytes_.size(); }

  /// Returns the fewest bytes that determine every symbol, whatever follows them. Then the encoder starts anew.
  std::vector<std::uint8_t> finish();

 private:
  void shift_byte();
  void carry();

  std::vector<std::uint8_t> bytes_;
  std::uint64_t low_ = 0;  // beginning of the interval after `bytes_`; 2^32 is a carry
  std::uint32_t range_ = 0xffffffff;
};

}  // namespace multum
