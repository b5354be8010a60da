// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/range_encoder.h"

#include <utility>

namespace multum {

void RangeEncoder::carry() {
  if (low_ >> 32 == 0) return;
  low_ &= 0xffffffff;
  // There is always an earlier byte below 255 that can take the carry, because the interval never leaves 0..1.
  for (auto byte = bytes_.rbegin(); ++*byte == 0;) ++byte;
}

void RangeEncoder::shift_byte() {
  bytes_.push_back(static_cast<std::uint8_t>(low_ >> 24));
  low_ = low_ << 8 & 0xffffffff;
}

void RangeEncoder::encode(bool bit, std::uint32_t probability) {
  const std::uint32_t bound = (range_ >> 16) * probability;
  if (bit) {
    range_ = bound;
  } else {
    low_ += bound;
    range_ -= bound;
    carry();
  }
  while (range_ < (1u << 24)) {
    shift_byte();
    range_ <<= 8;
  }
}

std::vector<std::uint8_t> RangeEncoder::finish() {
  // Finds the value with the most trailing zero bytes such that all its continuations are in the interval.
  for (int kept = 0; kept <= 4; ++kept) {
    const std::uint64_t open = kept == 4 ? 0 : 0xffffffffull >> (8 * kept);  // range of the bits that can follow
    const std::uint64_t value = (low_ + open) & ~open;
    if (value + open >= low_ + range_) continue;
    low_ = value;
    carry();
    for (int i = 0; i < kept; ++i) shift_byte();
    break;
  }
  low_ = 0;
  range_ = 0xffffffff;
  return std::exchange(bytes_, {});
}

}  // namespace multum
