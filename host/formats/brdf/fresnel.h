// SPDX-License-Identifier: Apache-2.0
// Evaluates F, the factor of a BRDF that depends on v.h alone: Schlick's term, or a measured BRDF's second factor.
#pragma once

#include <glm/vec3.hpp>

#include "host/formats/brdf/brdf.h"

namespace multum {

bool has_fresnel(const Brdf& brdf);
/// Its diffuse part is times 1 - F.
bool has_diffuse_fresnel(const Brdf& brdf);

/// (1 - v.h)^5.
double schlick_part(double v_h);
/// 1 where the BRDF has none.
glm::dvec3 fresnel(const Brdf& brdf, double v_h);

/// A number in the place of F where v.h stays above v_h_min: as far, relatively, from the least F as from the largest.
struct FixedFresnel {
  glm::dvec3 value{1.0};
  double change = 0.0;  // relative, the most that the highlight or the diffuse part of any channel differs
};
FixedFresnel fixed_fresnel(const Brdf& brdf, double v_h_min);

}  // namespace multum
