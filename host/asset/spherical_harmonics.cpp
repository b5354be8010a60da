// SPDX-License-Identifier: Apache-2.0
#include "host/asset/spherical_harmonics.h"

#include <cmath>

#include "host/base/error.h"

namespace multum {

std::vector<ShStep> sh_recurrence(int order) {
  MULTUM_CHECK(order >= 0 && order <= kShOrderMax);
  std::vector<ShStep> steps;
  double diagonal = kShConstant;  // p_mm without the sqrt(2) of Y_lm and Y_l,-m
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
  ZonalCoefficients a = zonal_blinn_phong(order, 1.0);  // 1/pi max(t, 0)
  for (double& value : a) value *= M_PI;
  return a;
}

// a_l = a_l-1 R_l, R_l = I_l+1/2 / I_l-1/2 = 1 / ((2l+1)/kappa + R_l+1), begun 30 above the last from the asymptotic
// ratio: begun from 0 it fails for large kappa.
ZonalCoefficients zonal_vmf(int order, double kappa) {
  ZonalCoefficients a(static_cast<std::size_t>(order) + 1, 0.0);
  a[0] = 1.0;
  if (kappa <= 0.0) return a;
  const double nu = order + 30.5;
  double ratio = kappa / (nu + std::sqrt(nu * nu + kappa * kappa));
  for (int l = order + 29; l >= 1; --l) {
    ratio = 1.0 / ((2.0 * l + 1.0) / kappa + ratio);
    if (l <= order) a[static_cast<std::size_t>(l)] = ratio;
  }
  for (std::size_t l = 1; l < a.size(); ++l) a[l] *= a[l - 1];
  return a;
}

ZonalCoefficients zonal_of(int order, const std::function<double(double)>& f) {
  // Gauss-Legendre of three nodes on 4096 pieces of each half of [0, pi]: lobes of one half end at 90 degrees.
  constexpr int kPieces = 8192;
  constexpr double kNodes[] = {-0.7745966692414834, 0.0, 0.7745966692414834}, kWeights[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  ZonalCoefficients a(static_cast<std::size_t>(order) + 1, 0.0);
  for (int i = 0; i < kPieces; ++i)
    for (int node = 0; node < 3; ++node) {
      constexpr double kStep = M_PI / kPieces;
      const double theta = (i + 0.5 + 0.5 * kNodes[node]) * kStep, t = std::cos(theta);
      const double value = 2.0 * M_PI * f(t) * std::sin(theta) * 0.5 * kStep * kWeights[node];
      if (value == 0.0) continue;
      double before = 0.0, p = 1.0;  // P_l-1, P_l
      for (int l = 0; l <= order; ++l) {
        a[static_cast<std::size_t>(l)] += value * p;
        const double next = ((2.0 * l + 1.0) * t * p - l * before) / (l + 1.0);
        before = p;
        p = next;
      }
    }
  return a;
}

}  // namespace multum
