// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics, and the coefficients of environments.
#pragma once

#include <array>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "host/formats/light/environment_map.h"

namespace multum {

/// Returns Y_lm of a unit direction for l = 0 .. `order`, at index l (l + 1) + m. The functions are orthonormal and
/// real, with polar axis z, without the Condon-Shortley sign. For m < 0, they have the factor sin(|m| phi).
std::vector<double> harmonics(const glm::dvec3& direction, int order);

/// The part of an environment with l <= 2, as a polynomial of the direction for each channel: L(n) = mean + linear . n
/// + n . quadratic n. Diffuse (Lambert) light depends only on this part, up to an error of about 1 % (Ramamoorthi and
/// Hanrahan 2001).
struct SmoothEnvironment {
  std::array<double, 3> mean;
  std::array<glm::dvec3, 3> linear;
  std::array<glm::dmat3, 3> quadratic;  // symmetric, with trace 0
};
SmoothEnvironment smooth_environment(const EnvironmentMap& map);

constexpr int kHalfVectorOrder = 8;

/// Returns the coefficients of L'(h) = 4 (v.h) (v.h) L(reflect(v, h)), l <= kHalfVectorOrder, for one view direction
/// (Han et al. 2007, section 8). Multiplying these coefficients by a normal distribution that was convolved with the
/// facets gives the highlight. Han's formula has one factor v.h, from the change of variables. The other factor v.h
/// replaces n.l. The factors v.h and n.l are equal at n = h, so each light is weighted approximately with its cosine.
/// `map` is small (shrink()) and in the frame of `v`.
std::vector<glm::dvec3> half_vector_light(const EnvironmentMap& map, const glm::dvec3& v);

}  // namespace multum
