// SPDX-License-Identifier: Apache-2.0
// Computes the reference of kernels/reflectance_pyramid.cl and reflectance.frag in double precision.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace multum::reference {

struct DistantLight {
  glm::dvec3 direction;   // unit vector towards the light
  glm::dvec3 irradiance;  // irradiance on a surface that faces the light
};

struct PhongSurface {
  double exponent;  // exponent s
  glm::dvec3 diffuse, specular;
};

/// Returns sum over lights E ( k_d / pi + k_s (s + 1) / (2 pi) max(n.h, 0)^s ) max(n.l, 0). `normal` and `viewer` are
/// unit vectors.
glm::dvec3 phong_radiance(const glm::dvec3& normal, const glm::dvec3& viewer, const std::vector<DistantLight>& lights,
                          const PhongSurface& surface);

}  // namespace multum::reference
