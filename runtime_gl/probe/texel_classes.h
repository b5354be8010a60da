// SPDX-License-Identifier: Apache-2.0
// Divides texels into classes, so that no filter footprint contains two texels of a class. The weight of a class in a
// pixel is then the weight of one texel. A trilinear footprint is 2 x 2 texels in each of two successive levels, so the
// parities of column, row and level make 8 classes. Anisotropic footprints are wider and need more classes.
//
// In each direction, a level of n texels is cut into blocks of at least `span` texels, and a texel's class is its place
// in its block. Any `span` neighbours then have different classes for any n, even across the seam of a periodic
// texture. (The parity of the column would not work for odd n.) A level shorter than `span` is one block, so every
// texel has its own class.
#pragma once

#include <vector>

#include "host/formats/asset/mip_layout.h"

namespace multum::gl {

/// The blocks of one level in one direction.
class TexelBlocks {
 public:
  TexelBlocks(int texel_count, int span);
  int class_of(int texel) const;
  /// Returns the length of the longest block.
  int class_count() const { return (texel_count_ + block_count_ - 1) / block_count_; }

 private:
  int texel_count_, block_count_;
};

class TexelClasses {
 public:
  /// `span` is the number of texels of a level that a footprint may reach in either direction, at least 2.
  /// `level_count` is the number of levels of `layout` that the sampler reads.
  TexelClasses(const MipLayout& layout, int level_count, int span);
  int class_of(int level, int x, int y) const;
  int class_count() const { return class_count_; }

 private:
  std::vector<TexelBlocks> columns_, rows_;
  int column_classes_ = 1, row_classes_ = 1, class_count_ = 1;
};

}  // namespace multum::gl
