// SPDX-License-Identifier: Apache-2.0
// Expresses the columns of coarser levels as sums over blocks of a row's texels. The nodes of a row are its texels,
// followed by the sums of its whole blocks of 2, 4, ... texels. A column of a level of any size is the sum of a few
// nodes:
//
//     finest texels   | 0 | 1 | 2 | 3 | 4 | 5 | 6 | ...
//     blocks of 2     |   0   |   1   |   2   | ...
//     a column              [ .4|    1  |  .6 ]            three taps: .4 of texel 1, block 1, .6 of texel 4
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace multum {

class RowBlocks {
 public:
  struct Tap {
    std::uint32_t node;
    double weight;  // number of finest texels
  };

  explicit RowBlocks(int row_width);

  std::size_t node_count() const { return node_count_; }
  /// Returns the number of block sizes. For each k from 0 to depth() - 1, the blocks of 2^k texels have a first node
  /// and a count.
  int depth() const { return static_cast<int>(block_begin_.size()); }
  std::size_t block_begin(int k) const { return block_begin_[static_cast<std::size_t>(k)]; }
  int block_count(int k) const { return row_width_ >> k; }
  /// Appends the taps of column `column` of a level of width `level_width`, from the left.
  void append_taps(int level_width, int column, std::vector<Tap>& taps) const;

 private:
  const int row_width_;
  std::vector<std::size_t> block_begin_;
  std::size_t node_count_ = 0;
};

}  // namespace multum
