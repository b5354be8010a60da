// SPDX-License-Identifier: Apache-2.0
// Describes ranges of rows of a level, or of its texels.
#pragma once

#include <algorithm>

namespace multum {

/// Rows [begin, end). On a map that repeats, these rows may be outside the borders.
struct LevelRows {
  int begin = 0, end = 0;
};

/// Returns the intersection of two ranges, which is empty if begin >= end.
inline LevelRows common_rows(const LevelRows& a, const LevelRows& b) {
  return {std::max(a.begin, b.begin), std::min(a.end, b.end)};
}

/// Texels [x0, x1) x [y0, y1) of a level.
struct TexelRange {
  int x0, y0, x1, y1;
};

}  // namespace multum
