// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/spherical_harmonics.h"

#include <algorithm>
#include <cmath>

#include "host/foundation/base/error.h"
#include "host/foundation/base/mean_cosine.h"

namespace multum {

std::vector<ShStep> sh_recurrence(int order) {
  MULTUM_CHECK(order >= 0 && order <= kShOrderMax);
  std::vector<ShStep> steps;
  double diagonal = kShConstant;  // p_mm without the factor sqrt(2) that is part of Y_lm and Y_l,-m
  for (int m = 0; m <= order; ++m) {
    if (m > 0) diagonal *= std::sqrt((2.0 * m + 1.0) / (2.0 * m));
    steps.push_back({static_cast<float>(m > 0 ? std::sqrt(2.0) * diagonal : diagonal), 0.0f});
    const double mm = static_cast<double>(m) * m;
    const auto a = [mm](double l) { return std::sqrt((4.0 * l * l - 1.0) / (l * l - mm)); };
    for (int l = m + 1; l <= order; ++l)
      steps.push_back({static_cast<float>(a(l)), static_cast<float>(l == m + 1 ? 0.0 : a(l) / a(l - 1.0))});
  }
  MULTUM_CHECK(static_cast<int>(steps.size()) == sh_step_count(order));
  return steps;
}

ZonalCoefficients zonal_blinn_phong(int order, double s) {
  ZonalCoefficients a = {1.0, (s + 1.0) / (s + 2.0)};
  for (int l = 2; l <= order; ++l) a.push_back(a[static_cast<std::size_t>(l) - 2] * (s - l + 2.0) / (s + l + 1.0));
  a.resize(static_cast<std::size_t>(order) + 1);
  return a;
}

ZonalCoefficients zonal_lambert(int order) {
  ZonalCoefficients a = zonal_blinn_phong(order, 1.0);  // coefficients of 1/pi max(t, 0)
  for (double& value : a) value *= M_PI;
  return a;
}

// a_l = a_(l-1) R_l, with R_l = I_(l+1/2) / I_(l-1/2) = 1 / ((2l + 1)/kappa + R_(l+1)). The recurrence runs downward.
// It starts well above the largest l that is needed, where R_l is approximated by its asymptotic quotient.
ZonalCoefficients zonal_vmf(int order, double mean_cosine) {
  constexpr int kAbove = 30;
  ZonalCoefficients a(static_cast<std::size_t>(order) + 1, 1.0);
  if (mean_cosine >= 1.0) return a;
  const double kappa = kappa_of_mean_cosine(mean_cosine, HUGE_VAL), middle = order + kAbove + 0.5;
  double quotient = kappa / (middle + std::sqrt(middle * middle + kappa * kappa));
  for (int l = order + kAbove - 1; l >= 1; --l) {
    quotient = kappa / (2.0 * l + 1.0 + kappa * quotient);
    if (l <= order) a[static_cast<std::size_t>(l)] = quotient;
  }
  for (std::size_t l = 1; l < a.size(); ++l) a[l] *= a[l - 1];
  return a;
}

ZonalCoefficients zonal_lambert_of_rough(int order, double mean_cosine) {
  constexpr double kLeastDivisor = 0.1;
  ZonalCoefficients a = zonal_lambert(order);
  const ZonalCoefficients weakened = zonal_vmf(order, mean_cosine);
  for (std::size_t l = 0; l < a.size(); ++l) a[l] /= std::max(weakened[l], kLeastDivisor);
  return a;
}

}  // namespace multum
