// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics, and environments in them.
#pragma once

#include <array>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "host/formats/light/environment_map.h"

namespace multum {

/// Y_lm of a unit direction for l = 0 .. `order`, at index l (l + 1) + m: orthonormal, real, z the polar axis, no
/// Condon-Shortley sign, m < 0 with sin(|m| phi).
std::vector<double> harmonics(const glm::dvec3& direction, int order);

/// The part of an environment with l <= 2, which is all that Lambert sees to about 1 % (Ramamoorthi and Hanrahan 2001),
/// as a polynomial of the direction: L(n) = mean + linear . n + n . quadratic n; one of each a channel.
struct SmoothEnvironment {
  std::array<double, 3> mean;
  std::array<glm::dvec3, 3> linear;
  std::array<glm::dmat3, 3> quadratic;  // symmetric, of trace 0
};
SmoothEnvironment smooth_environment(const EnvironmentMap& map);

constexpr int kHalfVectorOrder = 8;

/// Han et al. 2007, section 8: the coefficients of L'(h) = 4 (v.h) (v.h) L(reflect(v, h)), l <= kHalfVectorOrder, for
/// one view direction: what a normal distribution that was convolved with the facets is integrated with. Han's has one
/// v.h, of the change of variables; the other is n.l where n = h, so that each light counts with about its cosine.
/// `map`: small (shrink()), its frame is that of `v`.
std::vector<glm::dvec3> half_vector_light(const EnvironmentMap& map, const glm::dvec3& v);

}  // namespace multum
