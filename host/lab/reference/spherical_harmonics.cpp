// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/spherical_harmonics.h"

#include <cmath>
#include <cstdlib>

namespace multum::reference {

double sh_basis(int l, int m, const glm::dvec3& n) {
  const auto order = static_cast<unsigned>(std::abs(m));
  const double theta = std::atan2(std::hypot(n.x, n.y), n.z), phi = std::atan2(n.y, n.x);
  // The standard library's functions contain the Condon-Shortley phase (-1)^m, and lack the sqrt(2) of the real basis.
  const double p = std::sph_legendre(static_cast<unsigned>(l), order, theta) * (order % 2 == 0 ? 1.0 : -1.0);
  if (m == 0) return p;
  return std::sqrt(2.0) * p * (m > 0 ? std::cos(m * phi) : std::sin(-m * phi));
}

std::vector<double> sh_basis_to(int order, const glm::dvec3& n) {
  std::vector<double> values;
  for (int l = 1; l <= order; ++l)
    for (int m = -l; m <= l; ++m) values.push_back(sh_basis(l, m, n));
  return values;
}

// Integrates over the angle by the midpoint rule with 20000 points. The integrand is smooth on each side of 90 degrees.
std::vector<double> zonal_by_quadrature(int order, const std::function<double(double)>& f) {
  constexpr int kSteps = 20000;
  std::vector<double> sums(static_cast<std::size_t>(order) + 1, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    const double theta = M_PI * (i + 0.5) / kSteps, t = std::cos(theta);
    const double value = 2.0 * M_PI * f(t) * std::sin(theta) * M_PI / kSteps;
    for (std::size_t l = 0; l < sums.size(); ++l) sums[l] += value * std::legendre(static_cast<unsigned>(l), t);
  }
  return sums;
}

double shade_sh(const std::vector<double>& coefficients, double share, const std::vector<double>& zonal,
                const glm::dvec3& w) {
  double sum = zonal[0] * share / (4.0 * M_PI);
  std::size_t i = 0;
  for (int l = 1; l < static_cast<int>(zonal.size()); ++l)
    for (int m = -l; m <= l; ++m) sum += zonal[static_cast<std::size_t>(l)] * coefficients[i++] * sh_basis(l, m, w);
  return sum;
}

}  // namespace multum::reference
