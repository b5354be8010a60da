// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/moments.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/lab/reference/coverage.h"

namespace multum::reference {
TexelMoments moments_of_texel(const NormalMap& map, const ColourMap* albedo, int width, int height, int x, int y) {
  TexelMoments m;
  double total = 0.0;
  for_each_covered(map.width, map.height, width, height, x, y, [&](std::size_t i, double weight) {
    const glm::dvec3 n(static_cast<double>(map.x[i]), static_cast<double>(map.y[i]), static_cast<double>(map.z[i]));
    const double s = -n.x / std::max(n.z, 0.05), t = -n.y / std::max(n.z, 0.05);
    m.s += weight * s;
    m.t += weight * t;
    m.ss += weight * s * s;
    m.tt += weight * t * t;
    m.st += weight * s * t;
    m.normal += weight * n;
    if (albedo != nullptr)
      m.colour += weight * glm::dvec3(static_cast<double>(albedo->r[i]), static_cast<double>(albedo->g[i]),
                                      static_cast<double>(albedo->b[i]));
    total += weight;
  });
  for (double* sum : {&m.s, &m.t, &m.ss, &m.tt, &m.st}) *sum /= total;
  m.normal /= total;
  m.colour /= total;
  return m;
}

double toksvig(const glm::dvec3& mean_normal, const glm::dvec3& half_vector, double s) {
  const double length = std::min(glm::length(mean_normal), 1.0);
  const double exponent = s * length / (length + s * (1.0 - length));
  const double t = glm::dot(glm::normalize(mean_normal), half_vector);
  return t > 0.0 ? (exponent + 1.0) / (2.0 * M_PI) * std::pow(t, exponent) : 0.0;
}

double lean(const TexelMoments& m, const glm::dvec3& half_vector, double s, bool with_jacobian) {
  if (half_vector.z <= 0.0) return 0.0;
  const double variance_s = std::max(m.variance_s(), 0.0), variance_t = std::max(m.variance_t(), 0.0);
  const double xx = variance_s + 1.0 / s, yy = variance_t + 1.0 / s, limit = std::sqrt(variance_s * variance_t);
  const double xy = std::clamp(m.st - m.s * m.t, -limit, limit);
  const double determinant = xx * yy - xy * xy;
  const double dx = -half_vector.x / half_vector.z - m.s, dy = -half_vector.y / half_vector.z - m.t;
  const double distance = (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant;
  const double density = std::exp(-0.5 * distance) / (2.0 * M_PI * std::sqrt(determinant));
  return with_jacobian ? density / std::pow(half_vector.z, 3.0) : density;
}

}  // namespace multum::reference
