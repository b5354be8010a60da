// SPDX-License-Identifier: Apache-2.0
// Numbers the selected texels of a pyramid level by level, row by row, from left to right. The number of a texel is
// called its slot. The data of selected texels is therefore stored in a plain array.
#pragma once

#include <cstddef>
#include <vector>

#include "host/bakes/pyramid/mip_coverage.h"

namespace multum {

class TexelSelection {
 public:
  /// The `texels` of each level are given as y * width + x, in any order. Repeated texels count once.
  TexelSelection(std::vector<PlaneSize> sizes, std::vector<std::vector<int>> texels);

  const std::vector<PlaneSize>& sizes() const { return sizes_; }
  std::size_t slot_count() const { return columns_.size(); }
  /// Returns the first slot of a row of a level. The row may be one past the last row.
  std::size_t row_begin(int level, int row) const {
    return row_begin_[level_row_[static_cast<std::size_t>(level)] + static_cast<std::size_t>(row)];
  }
  std::size_t row_end(int level, int row) const { return row_begin(level, row + 1); }
  std::size_t level_begin(int level) const { return row_begin(level, 0); }
  int column(std::size_t slot) const { return columns_[slot]; }
  /// Returns the slot of a selected texel.
  std::size_t slot(int level, int texel) const;

 private:
  std::vector<PlaneSize> sizes_;
  std::vector<std::size_t> level_row_;  // [level]: index of the level's first row among the rows of all levels
  std::vector<std::size_t> row_begin_;  // [row, counted over all levels]: first slot of the row; the last entry is the
                                        // end of the last range
  std::vector<int> columns_;            // [slot]
};

}  // namespace multum
