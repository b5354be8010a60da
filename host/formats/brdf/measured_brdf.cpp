// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/measured_brdf.h"

#include <algorithm>
#include <cmath>

namespace multum {
namespace {

template <typename Value>
Value interpolate(const std::vector<Value>& table, double position) {
  const double last = static_cast<double>(table.size() - 1);
  const double x = std::clamp(position * last, 0.0, last);
  const auto i = std::min(static_cast<std::size_t>(x), table.size() - 2);
  const double t = x - static_cast<double>(i);
  return (1.0 - t) * table[i] + t * table[i + 1];
}

}  // namespace

glm::dvec3 measured_facets(const MeasuredBrdf& brdf, double e) {
  if (e >= 1.0) return glm::dvec3(0.0);
  const double theta = 2.0 * std::asin(std::sqrt(0.5 * std::max(e, 0.0)));
  return interpolate(brdf.facets, std::sqrt(theta / kHalfPi));
}

double measured_differences(const MeasuredBrdf& brdf, double v_h) {
  return interpolate(brdf.differences, std::acos(std::clamp(v_h, 0.0, 1.0)) / kHalfPi);
}

}  // namespace multum
