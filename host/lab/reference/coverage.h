// SPDX-License-Identifier: Apache-2.0
// Computes directly from the definition which finest texels each texel covers. A finest texel at the border of a texel
// is weighted by its covered fraction (docs/contributing/ALGORITHMS.md, "Notation").
#pragma once

#include <algorithm>
#include <cstddef>

namespace multum::reference {

/// Returns the length of the part of [index, index + 1) that lies within [texel from/to, (texel + 1) from/to).
inline double overlap(int index, int texel, int from, int to) {
  const double step = static_cast<double>(from) / to;
  return std::max(0.0, std::min(index + 1.0, (texel + 1) * step) - std::max<double>(index, texel * step));
}

/// Calls visit(i, weight) for every finest texel i = y * map_width + x that overlaps texel (x, y) of a level of `width`
/// x `height` texels. The weights are areas, in units of a finest texel.
template <typename Visit>
void for_each_covered(int map_width, int map_height, int width, int height, int x, int y, const Visit& visit) {
  for (int row = 0; row < map_height; ++row) {
    const double row_weight = overlap(row, y, map_height, height);
    if (row_weight <= 0.0) continue;
    for (int column = 0; column < map_width; ++column) {
      const double weight = row_weight * overlap(column, x, map_width, width);
      if (weight > 0.0)
        visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(map_width) + static_cast<std::size_t>(column),
              weight);
    }
  }
}

}  // namespace multum::reference
