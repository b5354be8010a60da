// SPDX-License-Identifier: Apache-2.0
// Tests that the quadrature integrates the polynomials for which it is exact.
#include "host/foundation/base/gauss_legendre.h"

#include <gtest/gtest.h>

#include <cmath>

namespace multum {
namespace {

TEST(GaussLegendreTest, PolynomialsAreExact) {
  for (const int count : {1, 2, 5, 9, 20}) {
    const QuadratureRule rule = gauss_legendre(count);
    for (int degree = 0; degree < 2 * count; ++degree) {
      double sum = 0.0;
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) sum += rule.weights[i] * std::pow(rule.nodes[i], degree);
      EXPECT_NEAR(sum, degree % 2 == 0 ? 2.0 / (degree + 1) : 0.0, 1e-13) << count << " nodes, degree " << degree;
    }
  }
}

}  // namespace
}  // namespace multum
