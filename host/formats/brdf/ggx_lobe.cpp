// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/ggx_lobe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace multum {

double shaded_kappa(double d) {
  const double mean_cosine = 1.0 - d, x = mean_cosine * mean_cosine;
  const double p = -0.20753 + x * (-0.12665 + x * (-1.04417 + x * 0.90242));
  return mean_cosine * (3.0 - x + x * (1.0 - x) * p) / std::max(d * (2.0 - d), 1e-12);
}

double ggx_lobe_density(const GgxLobeShape& shape, double alpha, double spread, double e) {
  const double square = alpha * alpha + 2.0 * spread;
  const double inverse_kappa = 1.0 / std::max(shaded_kappa(spread), 1e-6);
  const double reach = std::sqrt(inverse_kappa * (4.7 + 3.0 * inverse_kappa));
  const double u = std::clamp(0.5 + 0.5 * (1.0 - e) / std::max(reach, 1e-6), 0.0, 1.0);
  const double y = shape.slope * e * (1.0 - 0.5 * e / (1.0 + 5.0 * inverse_kappa)) / square;
  return shape.peak / (std::numbers::pi * square) * u * u * (3.0 - 2.0 * u) *
         std::pow(1.0 + y * (1.0 + shape.bend * y), -shape.power);
}

}  // namespace multum
