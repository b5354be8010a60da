// SPDX-License-Identifier: Apache-2.0
#include "host/codec/decoder/range_decoder.h"

namespace multum {

RangeDecoder::RangeDecoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
  for (int i = 0; i < 4; ++i) take_byte();
}

void RangeDecoder::take_byte() {
  const bool there = next_ < bytes_.size();
  code_ = code_ << 8 | (there ? bytes_[next_++] : 0u);
  unknown_ = unknown_ << 8 | (there ? 0u : 255u);
}

bool RangeDecoder::decode(std::uint32_t probability) {
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

}  // namespace multum
