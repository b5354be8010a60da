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

}  // namespace multum
