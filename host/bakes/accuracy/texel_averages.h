// SPDX-License-Identifier: Apache-2.0
// Exact averages over what some texels of a pyramid cover (host/bakes/pyramid/mip_coverage.h), of a plane that comes
// row by row: nothing of it is kept but a sum for each of these texels.
//
// Along a row, a texel of any level covers whole blocks of 2^k finest texels and fractions of one at the ends
// (row_blocks.h), so that one pass of pairwise sums over a row serves all levels, and a texel takes few additions a
// row.
#pragma once

#include <cstdint>
#include <vector>

#include "host/bakes/accuracy/texel_selection.h"
#include "host/bakes/pyramid/row_blocks.h"

namespace multum {

class TexelAverages {
 public:
  /// Averages over the texels selected in levels 0 to level_count - 1; level 0 is the plane itself. `texels` must
  /// outlive it.
  TexelAverages(const TexelSelection& texels, int level_count);

  const TexelSelection& texels() const { return texels_; }
  int level_count() const { return level_count_; }
  /// Slots of these levels, a sum each.
  std::size_t slot_count() const { return texels_.level_begin(level_count_); }
  /// A row of the plane with the sums of its blocks behind it: so many values.
  std::size_t row_length() const { return blocks_.node_count(); }
  /// Adds row y of the plane, of which row[0..width) is given, to sums[slot * stride]; the rest of `row` is written
  /// over. Sums begin as 0; rows come from the top, each once.
  void add_row(int y, double* row, double* sums, std::size_t stride) const;
  /// Factor that turns the sums of a level's slots into averages.
  double share(int level) const;

 private:
  struct Level {
    std::vector<std::uint32_t> tap_begin;  // [column]; one more ends the last; empty when no texel is selected
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
