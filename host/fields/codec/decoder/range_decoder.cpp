// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/range_decoder.h"

namespace multum {

RangeDecoder::RangeDecoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
  for (int i = 0; i < 4; ++i) take_byte();
}

void RangeDecoder::take_byte() {
  const bool there = next_ < bytes_.size();
  code_ = code_ << 8 | (there ? bytes_[next_++] : 0u);
  unknown_ = unknown_ << 8 | (there ? 0u : 255u);
}

}  // namespace multum
