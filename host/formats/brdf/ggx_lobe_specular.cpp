// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/ggx_lobe_specular.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/formats/brdf/vmf_terms.h"

namespace multum {
namespace {

constexpr double kAmplitudeMin = 1e-6;  // MULTUM_AMPLITUDE_MIN: below, no lobe

// multum_ggx_facet_kappa(): the facets' concentration about the half vector, `e` = 1 - mu . h.
double facet_kappa_of(double alpha, double kappa, double e) {
  const double x = alpha * alpha;
  double facets = 2.0 / x;
  for (int step = 0; step < 2; ++step) {
    const double sum = facets + kappa;
    const double size = std::sqrt(std::max(sum * sum - 2.0 * facets * kappa * e, 1e-12));
    const double beside = 2.0 * kappa * e * (size + kappa - facets) / (size * (size + sum));
    facets = 4.0 / ((1.0 + 0.5 * alpha) * (x + beside + 3.0 / sum));
  }
  return facets;
}

double smith_visibility_of(double alpha, double n_l, double n_v) {
  const double x = alpha * alpha;
  const double masking = n_l * std::sqrt(n_v * n_v * (1.0 - x) + x);
  const double shadowing = n_v * std::sqrt(n_l * n_l * (1.0 - x) + x);
  return 0.5 / std::max(masking + shadowing, 1e-6);
}

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
  kappa_ = shaded_kappa(spread_);
  shape_ = ggx_lobe_shape(alpha, spread_);
}

double GgxOverLobe::specular(const glm::dvec3& light, const glm::dvec3& view, const glm::dvec3& half) const {
  if (amplitude_ <= kAmplitudeMin) return 0.0;
  const glm::dvec3 difference = mean_direction_ - half;
  const double e = 0.5 * glm::dot(difference, difference);
  // The normals that reflect: facets about h times the lobe about mu, a vMF of this mean vector.
  const glm::dvec3 sum = facet_kappa_of(alpha_, kappa_, e) * half + kappa_ * mean_direction_;
  const double size = glm::length(sum), spread = spread_ > 0.0 ? vmf_spread(size) : 0.0;
  const double n_l = shaded_mean_cosine(spread, glm::dot(sum, light) / std::max(size, 1e-6));
  const double n_v = shaded_mean_cosine(spread, glm::dot(sum, view) / std::max(size, 1e-6));
  return amplitude_ * ggx_lobe_density(shape_, alpha_, spread_, e) * n_l * smith_visibility_of(alpha_, n_l, n_v);
}

}  // namespace multum
