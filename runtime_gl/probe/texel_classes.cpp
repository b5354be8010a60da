// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/probe/texel_classes.h"

#include <algorithm>

namespace multum::gl {

TexelBlocks::TexelBlocks(int texel_count, int span)
    : texel_count_(texel_count), block_count_(std::max(1, texel_count / span)) {}

int TexelBlocks::class_of(int texel) const {
  // Block b begins at ceil(b n / blocks), so lengths differ by at most one.
  const auto begin = [&](int block) { return (block * texel_count_ + block_count_ - 1) / block_count_; };
  int block = static_cast<int>(static_cast<long long>(texel) * block_count_ / texel_count_);
  if (begin(block) > texel) --block;
  return texel - begin(block);
}

TexelClasses::TexelClasses(const MipLayout& layout, int level_count, int span) {
  for (int l = 0; l < level_count; ++l) {
    const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(l)];
    columns_.emplace_back(level.width, span);
    rows_.emplace_back(level.height, span);
    column_classes_ = std::max(column_classes_, columns_.back().class_count());
    row_classes_ = std::max(row_classes_, rows_.back().class_count());
  }
  class_count_ = column_classes_ * row_classes_ * std::min(2, level_count);
}

int TexelClasses::class_of(int level, int x, int y) const {
  const auto l = static_cast<std::size_t>(level);
  return columns_[l].class_of(x) + column_classes_ * (rows_[l].class_of(y) + row_classes_ * (level & 1));
}

}  // namespace multum::gl
