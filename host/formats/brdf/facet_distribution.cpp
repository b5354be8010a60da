// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/facet_distribution.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/formats/brdf/measured_brdf.h"

namespace multum {
namespace {

// Half of the nodes and weights of Gauss-Legendre quadrature on [-1, 1] with 8 points.
constexpr double kNodes[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
constexpr double kWeights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

}  // namespace

glm::dvec3 facet_density(const Brdf& brdf, double e) {
  const BrdfFamily& family = family_of(brdf);
  if (family.is_file) return measured_facets(*brdf.measured, e);
  return glm::dvec3(family.density != nullptr ? family.density(width_of(brdf), e) : 0.0);
}

double equivalent_exponent(const Brdf& brdf) {
  const BrdfFamily& family = family_of(brdf);
  if (family.exponent != nullptr) return family.exponent(width_of(brdf));
  if (family.fit == BrdfFit::kNone) return 1.0;
  // Makes the two peaks equal: (s + 1) / (2 pi) = f(0) / integral of f.
  return std::max(2.0 * std::numbers::pi * mean_channel(facet_density(brdf, 0.0)) /
                          std::max(mean_channel(facet_total(brdf)), 1e-30) -
                      1.0,
                  1.0);
}

glm::dvec3 facet_total(const Brdf& brdf) {
  if (family_of(brdf).is_normalised) return glm::dvec3(1.0);
  return integrate_zonal([&](double e) { return facet_density(brdf, e); });
}

// The panels start at e = 1e-12 and double in width, so they resolve every wider f, no matter how its tail falls off.
// Densities of the hemisphere end at e = 1, where two panels meet.
glm::dvec3 integrate_zonal(const std::function<glm::dvec3(double)>& f) {
  glm::dvec3 sum(0.0);
  double begin = 0.0;
  for (int panel = 40; panel >= 0; --panel) {
    for (int part = 0; part < 4; ++part) {
      const double end = std::ldexp(1.0, -panel - 1) * (panel == 40 ? 0.25 * (part + 1) : 1.0 + 0.25 * (part + 1));
      const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
      for (int i = 0; i < 4; ++i)
        sum += kWeights[i] * half * (f(middle - kNodes[i] * half) + f(middle + kNodes[i] * half));
      begin = end;
    }
  }
  for (int part = 0; part < 4; ++part)
    for (int i = 0; i < 4; ++i) {
      const double middle = 1.125 + 0.25 * part;
      sum += kWeights[i] * 0.125 * (f(middle - 0.125 * kNodes[i]) + f(middle + 0.125 * kNodes[i]));
    }
  return 2.0 * std::numbers::pi * sum;
}

std::vector<glm::dvec3> zonal_coefficients(const Brdf& brdf, int order) {
  std::vector<glm::dvec3> coefficients;
  for (int l = 0; l <= order; ++l)
    coefficients.push_back(integrate_zonal([&](double e) {
      const auto degree = static_cast<unsigned>(l);
      return facet_density(brdf, e) * std::legendre(degree, 1.0 - e);
    }));
  return coefficients;
}

}  // namespace multum
