// SPDX-License-Identifier: Apache-2.0
// Computes the highlight of GGX convolved with a vMF lobe of normals in double precision, as renderers draw it. Follows
// multum_movmf_ggx_specular() of runtime_gl/shaders/brdf/ggx_lobe.glsl step by step. tests/gl/ggx_lobe_test compares
// the two.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/formats/brdf/ggx_lobe.h"

namespace multum {

/// Returns the mean of max(n . w, 0) over a vMF with spread `d`. `t` is the cosine of the angle between its mean
/// direction and w. Uses the formula of multum_vmf_mean_cosine() of runtime_gl/shaders/common/movmf_shading.glsl.
double shaded_mean_cosine(double d, double t);

/// One lobe that is shaded by GGX with one roughness.
class GgxOverLobe {
 public:
  /// `lobe` is (a r_x, a r_y, a r_z, a) as in baked files (host/formats/asset/lobes/movmf_mipmap.h). `alpha` is
  /// roughness^2, greater than 0 and at most 1.
  GgxOverLobe(const glm::dvec4& lobe, double alpha);

  /// Returns D V max(n . l, 0), times the amplitude. `light`, `view` and their half vector `half` are unit vectors in
  /// tangent space.
  double specular(const glm::dvec3& light, const glm::dvec3& view, const glm::dvec3& half) const;

 private:
  double amplitude_, spread_, alpha_;
  glm::dvec3 mean_direction_;
  GgxLobeShape shape_;
};

}  // namespace multum
