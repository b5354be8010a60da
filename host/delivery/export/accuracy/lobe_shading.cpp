// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/accuracy/lobe_shading.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

// Added to divisors, so that 0 / 0 becomes 0.
constexpr double kNotZero = 1e-300;

struct Planes {
  const double *x, *y, *z, *hx, *hy, *hz;
};

// The height-correlated visibility is V = 1 / (2 ((n . l) sqrt(a2 + (1 - a2) (n . v)^2) + (n . v) sqrt(a2 + (1 - a2) (n
// . l)^2))).
MULTUM_VECTOR_CLONES void add_all(const Planes& at, std::size_t count, const glm::dvec3& n, double nv, double a2,
                                  double weight, double* values, double* densities) {
  const double view_side = std::sqrt(a2 + (1.0 - a2) * nv * nv), peak = a2 * weight / std::numbers::pi;
  for (std::size_t i = 0; i < count; ++i) {
    const double nl = n.x * at.x[i] + n.y * at.y[i] + n.z * at.z[i];
    const double nh = n.x * at.hx[i] + n.y * at.hy[i] + n.z * at.hz[i];
    const double d = nh * nh * (a2 - 1.0) + 1.0;
    const double density = nh > 0.0 ? peak / (d * d) : 0.0;
    densities[i] += density * nh;
    const double lit = nl > 0.0 && nv > 0.0 ? nl : 0.0;
    const double v = 0.5 / (lit * view_side + std::abs(nv) * std::sqrt(a2 + (1.0 - a2) * lit * lit) + kNotZero);
    values[i] += density * v * lit;
  }
}

MULTUM_VECTOR_CLONES void all_of_lobe(const Planes& at, std::size_t count, const GgxLobe& lobe,
                                      const glm::dvec3& across, const glm::dvec3& view, double* values) {
  const glm::dvec3 n = lobe.normal, t = lobe.axis, b = across;
  const double at2 = lobe.alpha_wide * lobe.alpha_wide, ab2 = lobe.alpha_narrow * lobe.alpha_narrow;
  const double nv = n.x * view.x + n.y * view.y + n.z * view.z, tv = t.x * view.x + t.y * view.y + t.z * view.z;
  const double bv = b.x * view.x + b.y * view.y + b.z * view.z;
  const double view_side = std::sqrt(at2 * tv * tv + ab2 * bv * bv + nv * nv);
  const double peak = 1.0 / (std::numbers::pi * lobe.alpha_wide * lobe.alpha_narrow);
  for (std::size_t i = 0; i < count; ++i) {
    const double nl = n.x * at.x[i] + n.y * at.y[i] + n.z * at.z[i];
    const double tl = t.x * at.x[i] + t.y * at.y[i] + t.z * at.z[i];
    const double bl = b.x * at.x[i] + b.y * at.y[i] + b.z * at.z[i];
    const double nh = n.x * at.hx[i] + n.y * at.hy[i] + n.z * at.hz[i];
    const double th = t.x * at.hx[i] + t.y * at.hy[i] + t.z * at.hz[i];
    const double bh = b.x * at.hx[i] + b.y * at.hy[i] + b.z * at.hz[i];
    const double d = th * th / at2 + bh * bh / ab2 + nh * nh;
    const double lit = nl > 0.0 && nv > 0.0 && nh > 0.0 ? nl : 0.0;
    const double v =
        0.5 / (lit * view_side + std::abs(nv) * std::sqrt(at2 * tl * tl + ab2 * bl * bl + lit * lit) + kNotZero);
    values[i] = peak / (d * d) * v * lit;
  }
}

Planes light_planes(const LightSet& lights) {
  return {lights.x.data(), lights.y.data(), lights.z.data(), lights.hx.data(), lights.hy.data(), lights.hz.data()};
}

}  // namespace

GgxLobe GgxLobe::isotropic(const glm::dvec3& normal, double alpha) {
  return {normal, alpha, alpha, tangent_about(normal)};
}

glm::dvec3 tangent_about(const glm::dvec3& normal) {
  const glm::dvec3 x = glm::dvec3(1.0, 0.0, 0.0) - normal.x * normal;
  const double length = glm::length(x);
  return length > 1e-9 ? x / length : glm::dvec3(0.0, 0.0, -1.0);
}

void LightSet::add(const glm::dvec3& light) {
  const glm::dvec3 half = glm::normalize(view + light);
  x.push_back(light.x), y.push_back(light.y), z.push_back(light.z);
  hx.push_back(half.x), hy.push_back(half.y), hz.push_back(half.z);
  share.push_back(0.0);
}

void add_highlights(const LightSet& lights, const glm::dvec3& normal, double alpha_squared, double weight,
                    double* values, double* densities) {
  add_all(light_planes(lights), lights.size(), normal, glm::dot(normal, lights.view), alpha_squared, weight, values,
          densities);
}

void highlights(const LightSet& lights, const GgxLobe& lobe, std::vector<double>& values) {
  values.resize(lights.size());
  all_of_lobe(light_planes(lights), lights.size(), lobe, glm::cross(lobe.normal, lobe.axis), lights.view,
              values.data());
}

}  // namespace multum
