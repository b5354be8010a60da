// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/ggx_lobe_specular.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace multum {
namespace {

constexpr double kAmplitudeMin = 1e-6;  // same as MULTUM_AMPLITUDE_MIN; lobes with a smaller amplitude are empty

}  // namespace

double shaded_mean_cosine(double d, double t) {
  const double r = 1.0 - d, m = r * t;
  const double v = d * (0.25 + r * (0.2343 + r * 0.15232));
  const double x = std::min(m * m / std::max(v, 1e-20), 200.0);
  const double g = x * (0.4117 + r * (0.2857 - r * 0.3658) + 0.0080 * x);
  return 0.5 * (m + std::sqrt(m * m + v * std::exp(-g)));
}

GgxOverLobe::GgxOverLobe(const glm::dvec4& lobe, double alpha) : amplitude_(lobe.w), alpha_(alpha) {
  const double length = glm::length(glm::dvec3(lobe));
  spread_ = std::clamp((lobe.w - length) / std::max(lobe.w, kAmplitudeMin), 0.0, 1.0);
  mean_direction_ = length > 1e-12 ? glm::dvec3(lobe) / length : glm::dvec3(0.0, 0.0, 1.0);
  shape_ = ggx_lobe_shape(alpha, spread_);
}

double GgxOverLobe::specular(const glm::dvec3& light, const glm::dvec3& view, const glm::dvec3& half) const {
  if (amplitude_ <= kAmplitudeMin) return 0.0;
  const glm::dvec3 difference = mean_direction_ - half;
  const double e = 0.5 * glm::dot(difference, difference);
  const double x = alpha_ * alpha_, of_lobe = vmf_scatter(spread_), of_facets = 0.6 * x + 0.1 * e;
  const glm::dvec3 sum = of_lobe * half + of_facets * mean_direction_;
  const double both = of_lobe * of_facets, scale = 1.0 / (glm::length(sum) + both), variance = 0.15 * scale * both;
  const auto doubled = [&](const glm::dvec3& to) {
    const double m = scale * glm::dot(sum, to);
    return m + std::sqrt(m * m + variance);
  };
  const double n_l = doubled(light), n_v = doubled(view);
  const double masking = n_l * std::sqrt(n_v * n_v * (1.0 - x) + 4.0 * x);
  const double shadowing = n_v * std::sqrt(n_l * n_l * (1.0 - x) + 4.0 * x);
  return amplitude_ * ggx_lobe_density(shape_, alpha_, spread_, e) * n_l / std::max(masking + shadowing, 1e-6);
}

}  // namespace multum
