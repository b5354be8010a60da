// SPDX-License-Identifier: Apache-2.0
// Computes exact averages over the area of selected texels of a pyramid (host/bakes/pyramid/mip_coverage.h). The rows
// of the plane are added one by one, and only one sum per selected texel is kept.
//
// Along a row, a texel of any level covers whole blocks of 2^k finest texels and fractions of a texel at the ends
// (row_blocks.h). The pairwise sums of a row are therefore computed once for all levels, and each texel takes only a
// few additions per row.
#pragma once

#include <cstdint>
#include <vector>

#include "host/bakes/accuracy/texel_selection.h"
#include "host/bakes/pyramid/row_blocks.h"

namespace multum {

class TexelAverages {
 public:
  /// Computes averages over the texels that are selected in levels 0 to level_count - 1. Level 0 is the plane itself.
  /// `texels` must outlive the object.
  TexelAverages(const TexelSelection& texels, int level_count);

  const TexelSelection& texels() const { return texels_; }
  int level_count() const { return level_count_; }
  /// Returns the number of slots of these levels. Each slot has one sum.
  std::size_t slot_count() const { return texels_.level_begin(level_count_); }
  /// Returns the number of values in a row of the plane, plus the number of block sums that follow the row.
  std::size_t row_length() const { return blocks_.node_count(); }
  /// Adds row y of the plane, row[0..width), to sums[slot * stride] and overwrites the rest of `row`. Sums start at 0.
  /// Add each row once, from the top.
  void add_row(int y, double* row, double* sums, std::size_t stride) const;
  /// Returns the factor that converts the sums of a level's slots to averages.
  double share(int level) const;

 private:
  struct Level {
    std::vector<std::uint32_t> tap_begin;  // [column], then the end of the last range; empty if no texel is selected
    std::vector<RowBlocks::Tap> taps;
  };
  Level make_level(int width) const;
  void sum_blocks(double* row) const;

  const TexelSelection& texels_;
  int level_count_;
  const RowBlocks blocks_;
  std::vector<Level> levels_;
};

}  // namespace multum
