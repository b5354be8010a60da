// SPDX-License-Identifier: Apache-2.0
// Gauss-Legendre quadrature on [-1, 1].
#pragma once

#include <vector>

namespace multum {

struct QuadratureRule {
  std::vector<double> nodes, weights;  // the weights add up to 2
};

/// Returns the rule with `count` nodes, which is exact for polynomials up to degree 2 count - 1.
QuadratureRule gauss_legendre(int count);

}  // namespace multum
