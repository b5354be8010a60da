// SPDX-License-Identifier: Apache-2.0
#include "host/formats/light/harmonics.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace multum {
namespace {

template <typename Use>
void for_each_texel(const EnvironmentMap& map, const Use& use) {
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      use(environment_direction((x + 0.5) / map.width, (y + 0.5) / map.height),
          texel_solid_angle(map.width, map.height, y) *
              glm::dvec3(map.texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                                    static_cast<std::size_t>(x)]));
}

}  // namespace

// Computes K_lm P_lm(z) / sin^m by upward recurrence in l, times sin^m (cos, sin)(m phi) as polynomials of x and y.
// Needs no angles, and does not divide by sin at the poles.
std::vector<double> harmonics(const glm::dvec3& d, int order) {
  const auto index = [](int l, int m) { return static_cast<std::size_t>(l * (l + 1) + m); };
  std::vector<double> y(index(order, order) + 1);
  double cosine = 1.0, sine = 0.0;                       // sin^m theta times (cos, sin)(m phi)
  double diagonal = std::sqrt(0.25 / std::numbers::pi);  // K_mm P_mm / sin^m
  for (int m = 0; m <= order; ++m) {
    if (m > 0) {
      const double next = d.x * cosine - d.y * sine;
      sine = d.x * sine + d.y * cosine;
      cosine = next;
      diagonal *= std::sqrt((2.0 * m + 1.0) / (2.0 * m));
    }
    double before = 0.0, p = diagonal;
    for (int l = m; l <= order; ++l) {
      if (l > m) {
        const double a = std::sqrt((4.0 * l * l - 1.0) / (l * l - m * m));
        const double b =
            l - 1 > m ? std::sqrt(((l - 1.0) * (l - 1.0) - m * m) / (4.0 * (l - 1.0) * (l - 1.0) - 1.0)) : 0.0;
        const double next = a * (d.z * p - b * before);
        before = p;
        p = next;
      }
      const double scale = m > 0 ? std::sqrt(2.0) : 1.0;
      y[index(l, m)] = scale * p * cosine;
      if (m > 0) y[index(l, -m)] = scale * p * sine;
    }
  }
  return y;
}

// Uses moments. The projection to l = 1 is 3/(4 pi) times the first moment. The projection to l = 2 is 15/(8 pi) times
// the second moment without its trace.
SmoothEnvironment smooth_environment(const EnvironmentMap& map) {
  SmoothEnvironment smooth{
      {}, {glm::dvec3(0.0), glm::dvec3(0.0), glm::dvec3(0.0)}, {glm::dmat3(0.0), glm::dmat3(0.0), glm::dmat3(0.0)}};
  for_each_texel(map, [&](const glm::dvec3& d, const glm::dvec3& light) {
    const glm::dmat3 square = glm::outerProduct(d, d) - glm::dmat3(1.0 / 3.0);
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<std::size_t>(c);
      smooth.mean[i] += light[c] / (4.0 * std::numbers::pi);
      smooth.linear[i] += light[c] * 3.0 / (4.0 * std::numbers::pi) * d;
      smooth.quadratic[i] += light[c] * 15.0 / (8.0 * std::numbers::pi) * square;
    }
  });
  return smooth;
}

// dl = 4 (v.h) dh, so the integrand over directions of light is L(l) (v.h).
std::vector<glm::dvec3> half_vector_light(const EnvironmentMap& map, const glm::dvec3& v) {
  std::vector<glm::dvec3> sum((kHalfVectorOrder + 1) * (kHalfVectorOrder + 1), glm::dvec3(0.0));
  for_each_texel(map, [&](const glm::dvec3& l, const glm::dvec3& light) {
    const double size = glm::length(l + v);
    if (size < 1e-6) return;  // here v.h is 0
    const glm::dvec3 h = (l + v) / size;
    const std::vector<double> y = harmonics(h, kHalfVectorOrder);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += y[i] * glm::dot(v, h) * light;
  });
  return sum;
}

}  // namespace multum
