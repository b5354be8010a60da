// SPDX-License-Identifier: Apache-2.0
// Places the texels of a mip pyramid in one list. The finest level comes first, and each level begins with its top row.
// The sizes of levels are rounded down (ROUND_DOWN), as in OpenGL: level l is max(1, width >> l) by max(1, height >>
// l), down to 1 x 1.
#pragma once

#include <algorithm>
#include <vector>

namespace multum {

struct MipLevelPlace {
  int width = 1, height = 1;
  int offset = 0;  // offset of the level's first texel
};

struct MipLayout {
  std::vector<MipLevelPlace> levels;
  int texel_count = 0;

  MipLayout() = default;
  MipLayout(int width, int height) {
    for (int l = 0;; ++l) {
      const MipLevelPlace level{std::max(1, width >> l), std::max(1, height >> l), texel_count};
      levels.push_back(level);
      texel_count += level.width * level.height;
      if (level.width == 1 && level.height == 1) break;
    }
  }
  int level_count() const { return static_cast<int>(levels.size()); }
  /// Returns the level that contains a texel.
  int level_of(int texel) const {
    int l = level_count() - 1;
    while (levels[static_cast<std::size_t>(l)].offset > texel) --l;
    return l;
  }
  /// Calls visit(parent, texel) for every texel of `level`, row by row. `level` must not be the coarsest level. The
  /// parent is the texel of the next coarser level that contains the texel. If a side is odd, the last texel has the
  /// same parent as its neighbour.
  template <typename Visit>
  void for_each_child(std::size_t level, const Visit& visit) const {
    const MipLevelPlace &fine = levels[level], &coarse = levels[level + 1];
    for (int y = 0; y < fine.height; ++y)
      for (int x = 0; x < fine.width; ++x)
        visit(static_cast<std::size_t>(coarse.offset + std::min(y / 2, coarse.height - 1) * coarse.width +
                                       std::min(x / 2, coarse.width - 1)),
              static_cast<std::size_t>(fine.offset + y * fine.width + x));
  }
};

}  // namespace multum
