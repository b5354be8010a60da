// SPDX-License-Identifier: Apache-2.0
// Rules by which engines make a normal map's mips: averaged normals, renormalised, with a roughness that grows as they
// get shorter. Each rule as its source has it, read in October 2026.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/delivery/export/accuracy/lobe_shading.h"

namespace multum {

/// What a rule sees of a texel.
struct RuleInput {
  glm::dvec3 mean_normal{0.0, 0.0, 1.0};  // average of unit normals, length 0..1
  double roughness = 0.5;                 // perceptual, averaged, 0..1
};

struct EngineRule {
  const char* id;      // "unreal", as JSON has it
  const char* name;    // "Unreal"
  const char* source;  // file and function
  /// Perceptual roughness for the normal's length and the base roughness.
  double (*roughness)(double length, double roughness);
};

/// Averaged normals alone first.
const std::vector<EngineRule>& engine_rules();

GgxLobe lobe_of_rule(const EngineRule& rule, const RuleInput& texel);

/// kappa of vMF for a mean of this length, 0..1 (Banerjee et al. 2005, eq. 4.4, of three dimensions); at most 1e9.
double kappa_of_length(double length);

}  // namespace multum
