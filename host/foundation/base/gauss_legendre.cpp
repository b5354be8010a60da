// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/gauss_legendre.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace multum {

QuadratureRule gauss_legendre(int count) {
  QuadratureRule rule;
  for (int i = 0; i < count; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5)), slope = 0.0;
    for (int step = 0; step < 50; ++step) {  // Newton's method, which converges in five steps
      double p = 1.0, before = 0.0;
      for (int j = 0; j < count; ++j) before = std::exchange(p, ((2 * j + 1) * x * p - j * before) / (j + 1));
      slope = count * (x * p - before) / (x * x - 1.0);
      x -= p / slope;
    }
    rule.nodes.push_back(x);
    rule.weights.push_back(2.0 / ((1.0 - x * x) * slope * slope));
  }
  return rule;
}

}  // namespace multum
