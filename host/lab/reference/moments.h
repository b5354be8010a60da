// SPDX-License-Identifier: Apache-2.0
// Moments of a texel by their definition, in double, and what Toksvig's rule and LEAN make of them: what
// kernels/moments.cl, kernels/device/moment_shading.clh and moment_shading.glsl are held to.
#pragma once

#include <glm/vec3.hpp>

#include "host/formats/image/normals/normal_map.h"

namespace multum::reference {

struct TexelMoments {
  double s = 0.0, t = 0.0, ss = 0.0, tt = 0.0, st = 0.0;  // of slopes -(n_x, n_y) / max(n_z, 0.05)
  glm::dvec3 normal{0.0};
  glm::dvec3 colour{0.0};

  double variance_s() const { return ss - s * s; }
  double variance_t() const { return tt - t * t; }
};

/// Of texel (x, y) of a level `width` by `height`: every finest texel weighs the area that the texel covers of it.
/// `albedo` may be null.
TexelMoments moments_of_texel(const NormalMap& map, const ColourMap* albedo, int width, int height, int x, int y);

/// Normalised Blinn-Phong at the unit half vector, its exponent shortened by Toksvig's rule; no cosine.
double toksvig(const glm::dvec3& mean_normal, const glm::dvec3& half_vector, double s);

/// A Gaussian density of slopes of covariance Sigma + I/s at the half vector's slope; with the Jacobian per solid
/// angle.
double lean(const TexelMoments& m, const glm::dvec3& half_vector, double s, bool with_jacobian);

}  // namespace multum::reference
