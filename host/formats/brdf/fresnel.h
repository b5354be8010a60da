// SPDX-License-Identifier: Apache-2.0
// Evaluates F, the factor of a BRDF that depends only on v.h: Schlick's term, or the second factor of a measured BRDF.
#pragma once

#include <glm/vec3.hpp>

#include "host/formats/brdf/brdf.h"

namespace multum {

bool has_fresnel(const Brdf& brdf);
/// Returns whether the diffuse part is multiplied by 1 - F.
bool has_diffuse_fresnel(const Brdf& brdf);

/// Returns (1 - v.h)^5.
double schlick_part(double v_h);
/// Returns F, or 1 if the BRDF has no F.
glm::dvec3 fresnel(const Brdf& brdf, double v_h);

/// A constant that replaces F while v.h stays above v_h_min. The relative difference between the constant and F is the
/// same for the smallest F and for the largest F.
struct FixedFresnel {
  glm::dvec3 value{1.0};
  double change = 0.0;  // largest relative change, in any channel, of the highlight or of the diffuse part
};
FixedFresnel fixed_fresnel(const Brdf& brdf, double v_h_min);

}  // namespace multum
