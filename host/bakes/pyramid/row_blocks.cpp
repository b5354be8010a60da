// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/row_blocks.h"

#include <algorithm>

namespace multum {

RowBlocks::RowBlocks(int row_width) : row_width_(row_width) {
  for (int blocks = row_width; blocks > 0; blocks /= 2) {
    block_begin_.push_back(node_count_);
    node_count_ += static_cast<std::size_t>(blocks);
  }
}

// Positions are integers in units of 1/level_width of a texel of the finest level.
void RowBlocks::append_taps(int level_width, int column, std::vector<Tap>& taps) const {
  const std::int64_t unit = level_width;
  std::int64_t position = std::int64_t{column} * row_width_;
  for (const std::int64_t end = (std::int64_t{column} + 1) * row_width_; position < end;) {
    const std::int64_t texel = position / unit, left = std::min((texel + 1) * unit, end) - position;
    if (left < unit) {
      taps.push_back({static_cast<std::uint32_t>(texel), static_cast<double>(left) / static_cast<double>(unit)});
      position += left;
      continue;
    }
    std::size_t k = 0;  // exponent of the largest block that begins here and ends at or before `end`
    while (texel % (std::int64_t{2} << k) == 0 && (texel + (std::int64_t{2} << k)) * unit <= end) ++k;
    taps.push_back({static_cast<std::uint32_t>(block_begin_[k] + static_cast<std::size_t>(texel >> k)), 1.0});
    position += unit << k;
  }
}

}  // namespace multum
