// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/ggx_lobe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace multum {

double vmf_scatter(double d) { return d / (1.001 - d); }

double ggx_lobe_density(const GgxLobeShape& shape, double alpha, double spread, double e) {
  const double square = alpha * alpha + 2.0 * spread;
  const double reach = std::sqrt(4.5 * vmf_scatter(spread) + 1e-12);
  const double u = std::clamp(0.5 + 0.5 * (1.0 - e) / reach, 0.0, 1.0);
  const double y = shape.slope * e / square * (1.0 - 0.5 * e * alpha * alpha / square);
  return shape.peak / (std::numbers::pi * square) * u * u * (3.0 - 2.0 * u) *
         std::pow(1.0 + y * (1.0 + shape.bend * y), -shape.power);
}

}  // namespace multum
