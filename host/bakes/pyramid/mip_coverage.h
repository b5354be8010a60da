// SPDX-License-Identifier: Apache-2.0
// Computes exact box averages over the finest texels that a texel of a coarser level covers
// (docs/contributing/ALGORITHMS.md, "Notation"). Texel x of a level of width w covers [x W/w, (x + 1) W/w), including
// fractions of texels. If the sizes are powers of two, it covers whole texels only.
#pragma once

#include <vector>

namespace multum {

struct PlaneSize {
  int width;
  int height;
};

/// Computes the averages of `plane` (row-major, size `from`) over the texels of a level of size `to` in double
/// precision. On each axis, to <= from.
std::vector<double> average_over_texels(const std::vector<double>& plane, PlaneSize from, PlaneSize to, int threads);

}  // namespace multum
