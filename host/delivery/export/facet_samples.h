// SPDX-License-Identifier: Apache-2.0
// Places and facets with which one lobe is fitted to a texel (kernels/one_lobe.cl): a grid of places, evenly spread
// over what the texel covers, and at each the slope of one facet of GGX.
#pragma once

#include <vector>

#include <glm/vec2.hpp>

namespace multum {

/// Samples along a side of a texel of this level, a power of two: as many places as a level of even sides has texels
/// below it, and never fewer than 8 nor more than 32. Of five real maps, base roughness 0.1 and 0.25: 16 instead of 8
/// lower the error at level 2 by 0.4 points of 54 on average, 4 raise it by 5; 16 instead of 32 raise that of level 6
/// by 0.6 of 65.
int sample_grid(int level);

/// Slopes of facets of GGX of alpha 1 about their normal, grid * grid, row by row of the grid. `grid`: a power of two
/// from 1 to 64.
///
/// Neighbours on the grid have facets that are far apart: those of any aligned square of 2 x 2, 4 x 4, ... samples,
/// which lie in one finest texel or a few, are spread evenly over the distribution by themselves. Such are the points
/// of a (0, 2)-sequence in the order of the squares (Kollig and Keller 2002, "Efficient multidimensional sampling",
/// section 3.1), mapped to slopes by tan theta = sqrt(u / (1 - u)). They are scaled, by some 1 %, so that the maximum
/// likelihood of all of them is alpha = 1: a texel of one normal keeps its roughness.
std::vector<glm::vec2> facet_samples(int grid);

/// Row or column of the finest level, `fine` texels long, of sample `sample` of texel `texel` of a level of `coarse`.
inline int sample_place(int texel, int sample, int grid, int coarse, int fine) {
  const long long halves = 2LL * (static_cast<long long>(texel) * grid + sample) + 1;
  return static_cast<int>(halves * fine / (2LL * grid * coarse));
}

}  // namespace multum
