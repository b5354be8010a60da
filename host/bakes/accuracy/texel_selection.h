// SPDX-License-Identifier: Apache-2.0
// Numbers selected texels of each level of a pyramid. Each has a slot: its number among them, level by level, row by
// row, left to right, so that what is kept for these texels alone is a plain array.
#pragma once

#include <cstddef>
#include <vector>

#include "host/bakes/pyramid/mip_coverage.h"

namespace multum {

class TexelSelection {
 public:
  /// `texels` of each level are y * width + x, in any order; one that is named twice is selected once.
  TexelSelection(std::vector<PlaneSize> sizes, std::vector<std::vector<int>> texels);

  const std::vector<PlaneSize>& sizes() const { return sizes_; }
  std::size_t slot_count() const { return columns_.size(); }
  /// The first slot of a row of a level, also of the row behind the last.
  std::size_t row_begin(int level, int row) const {
    return row_begin_[level_row_[static_cast<std::size_t>(level)] + static_cast<std::size_t>(row)];
  }
  std::size_t row_end(int level, int row) const { return row_begin(level, row + 1); }
  std::size_t level_begin(int level) const { return row_begin(level, 0); }
  int column(std::size_t slot) const { return columns_[slot]; }
  /// The slot of a texel that is selected.
  std::size_t slot(int level, int texel) const;

 private:
  std::vector<PlaneSize> sizes_;
  std::vector<std::size_t> level_row_;  // [level]: its first row among the rows of all levels
  std::vector<std::size_t> row_begin_;  // [row of all levels]: its first slot; one more ends the last
  std::vector<int> columns_;            // [slot]
};

}  // namespace multum
