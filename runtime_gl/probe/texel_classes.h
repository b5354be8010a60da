// SPDX-License-Identifier: Apache-2.0
// Divides texels into classes, so that no filter footprint holds two of one class: what a class weighs in a pixel is
// then one texel's weight. A trilinear footprint is 2 x 2 texels in each of two successive levels: the parities of
// column, row and level make 8 classes. Anisotropic footprints are wider and want more.
//
// A level of n texels in a direction is cut into blocks, each at least `span` long, and a texel's class is its place in
// its block: any `span` neighbours then have different classes, across the seam of a periodic texture too, whatever n
// is (odd ones break plain parity). A level shorter than `span` is one block: every texel has a class of its own.
#pragma once

#include <vector>

#include "host/formats/asset/mip_layout.h"

namespace multum::gl {

/// One direction of one level.
class TexelBlocks {
 public:
  TexelBlocks(int texel_count, int span);
  int class_of(int texel) const;
  /// Length of the longest block.
  int class_count() const { return (texel_count_ + block_count_ - 1) / block_count_; }

 private:
  int texel_count_, block_count_;
};

class TexelClasses {
 public:
  /// `span`: texels of a level that a footprint may reach in either direction, at least 2. `level_count`: of those
  /// in `layout`, the ones that the sampler reads.
  TexelClasses(const MipLayout& layout, int level_count, int span);
  int class_of(int level, int x, int y) const;
  int class_count() const { return class_count_; }

 private:
  std::vector<TexelBlocks> columns_, rows_;
  int column_classes_ = 1, row_classes_ = 1, class_count_ = 1;
};

}  // namespace multum::gl
