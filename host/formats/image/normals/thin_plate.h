// SPDX-License-Identifier: Apache-2.0
// A thin plate between bounds. Minimises the bending energy of heights h on a grid,
//   E(h) = 1/2 sum (h_xx^2 + h_yy^2 + 2 h_xy^2)   subject to   |h - code| <= 1/2,
// over the second differences that no cut crosses.
#pragma once

#include <vector>

namespace multum {

/// A grid of `width` x `height` codes in row-major order. NaN means that there is no height.
struct PlateProblem {
  int width = 0;
  int height = 0;
  std::vector<float> codes;
};

/// Returns the heights of the plate, which are within 1/2 of the codes, or 0 for texels without a code. Neighbours
/// whose codes differ by more than 1.5 are cut apart. Computes in a fixed order.
std::vector<float> thin_plate(const PlateProblem& problem);

}  // namespace multum
