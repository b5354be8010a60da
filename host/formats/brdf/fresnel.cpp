// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/fresnel.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "host/formats/brdf/measured_brdf.h"

namespace multum {

bool has_diffuse_fresnel(const Brdf& brdf) { return family_of(brdf).has_f0(); }

bool has_fresnel(const Brdf& brdf) { return has_diffuse_fresnel(brdf) || family_of(brdf).is_file; }

double schlick_part(double v_h) { return std::pow(std::clamp(1.0 - v_h, 0.0, 1.0), 5.0); }

glm::dvec3 fresnel(const Brdf& brdf, double v_h) {
  if (family_of(brdf).is_file) return glm::dvec3(measured_differences(*brdf.measured, v_h));
  if (!has_diffuse_fresnel(brdf)) return glm::dvec3(1.0);
  const glm::dvec3 f0(brdf.f0);
  return f0 + (glm::dvec3(1.0) - f0) * schlick_part(v_h);
}

// With c = 2 low high / (low + high), |F - c| / F is equal at both ends.
FixedFresnel fixed_fresnel(const Brdf& brdf, double v_h_min) {
  constexpr int kSteps = 256;  // measured factors need not be monotone
  glm::dvec3 low(fresnel(brdf, 1.0)), high(low);
  for (int i = 0; i < kSteps; ++i) {
    const glm::dvec3 f = fresnel(brdf, v_h_min + (1.0 - v_h_min) * i / kSteps);
    low = glm::min(low, f);
    high = glm::max(high, f);
  }
  FixedFresnel fixed;
  for (int c = 0; c < 3; ++c) {
    const double sum = low[c] + high[c];
    fixed.value[c] = sum > 0.0 ? 2.0 * low[c] * high[c] / sum : 0.0;
    if (brdf.specular[c] > 0.0f && high[c] > 0.0)
      fixed.change = std::max(fixed.change, low[c] > 0.0 ? (high[c] - low[c]) / sum : 1.0);
    if (!has_diffuse_fresnel(brdf) || !(brdf.diffuse[c] > 0.0f) || low[c] >= 1.0) continue;
    fixed.change = std::max(fixed.change, high[c] < 1.0 ? (high[c] - fixed.value[c]) / (1.0 - high[c]) : 1.0);
    fixed.change = std::max(fixed.change, (fixed.value[c] - low[c]) / (1.0 - low[c]));
  }
  fixed.change = std::min(fixed.change, 1.0);
  return fixed;
}

}  // namespace multum
