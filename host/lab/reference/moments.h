// SPDX-License-Identifier: Apache-2.0
// Computes the moments of a texel directly from their definition, in double precision, and shades them by Toksvig's
// rule and by LEAN. Tests use this code to check kernels/moments.cl, kernels/device/moment_shading.clh and
// moment_shading.glsl.
#pragma once

#include <glm/vec3.hpp>

#include "host/formats/image/normals/normal_map.h"

namespace multum::reference {

struct TexelMoments {
  double s = 0.0, t = 0.0, ss = 0.0, tt = 0.0, st = 0.0;  // moments of slopes -(n_x, n_y) / max(n_z, 0.05)
  glm::dvec3 normal{0.0};
  glm::dvec3 colour{0.0};

  double variance_s() const { return ss - s * s; }
  double variance_t() const { return tt - t * t; }
};

/// Returns the moments of texel (x, y) of a level of `width` x `height` texels. The weight of every finest texel is its
/// area within the texel. `albedo` may be null.
TexelMoments moments_of_texel(const NormalMap& map, const ColourMap* albedo, int width, int height, int x, int y);

/// Returns the normalised Blinn-Phong highlight at the unit half vector, without the cosine factor. Toksvig's rule
/// reduces its exponent.
double toksvig(const glm::dvec3& mean_normal, const glm::dvec3& half_vector, double s);

/// Returns the Gaussian density of slopes with covariance Sigma + I/s at the half vector's slope. If `with_jacobian` is
/// true, the density is per solid angle.
double lean(const TexelMoments& m, const glm::dvec3& half_vector, double s, bool with_jacobian);

}  // namespace multum::reference
