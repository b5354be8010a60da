// SPDX-License-Identifier: Apache-2.0
// Implements the rules by which engines make the mips of a normal map. The rules average and renormalize the normals,
// and the roughness is increased more if the average is shorter. Each rule follows the engine's source code of October
// 2026.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/delivery/export/accuracy/lobe_shading.h"

namespace multum {

/// The input of a rule for one texel.
struct RuleInput {
  glm::dvec3 mean_normal{0.0, 0.0, 1.0};  // average of unit normals; its length is 0 to 1
  double roughness = 0.5;                 // averaged perceptual roughness, 0..1
};

struct EngineRule {
  const char* id;      // name in JSON, such as "unreal"
  const char* name;    // human-readable name, such as "Unreal"
  const char* source;  // source file and function
  /// Computes perceptual roughness from the normal's length and the base roughness.
  double (*roughness)(double length, double roughness);
};

/// Returns all rules. The first rule only averages normals.
const std::vector<EngineRule>& engine_rules();

GgxLobe lobe_of_rule(const EngineRule& rule, const RuleInput& texel);

/// Returns the kappa of a vMF distribution whose mean has this length, 0 to 1 (Banerjee et al. 2005, eq. 4.4, in three
/// dimensions). The result is at most 1e9.
double kappa_of_length(double length);

}  // namespace multum
