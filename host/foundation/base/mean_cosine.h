// SPDX-License-Identifier: Apache-2.0
// Converts mean cosines of von Mises-Fisher lobes to kappas, in double precision.
#pragma once

#include <algorithm>
#include <cmath>

namespace multum {

/// Returns kappa for a mean cosine r, at most `kappa_max`. Uses Banerjee's approximation and two Newton steps.
inline double kappa_of_mean_cosine(double r, double kappa_max) {
  r = std::min(r, 1.0 - 1e-9);
  if (r > 0.9) return std::min(1.0 / (1.0 - r), kappa_max);
  double kappa = std::max((3.0 * r - r * r * r) / (1.0 - r * r), 0.05);
  for (int step = 0; step < 2; ++step) {
    const double a = 1.0 / std::tanh(kappa) - 1.0 / kappa;
    kappa = std::max(kappa - (a - r) / (1.0 - a * a - 2.0 * a / kappa), 0.05);
  }
  return std::min(kappa, kappa_max);
}

}  // namespace multum
