// SPDX-License-Identifier: Apache-2.0
// Describes how engines look up a material's textures, and how they increase roughness where normals change from pixel
// to pixel.
#pragma once

#include <glm/vec3.hpp>

#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

struct EngineFilter {
  /// The term that increases roughness if the normal changes between pixels.
  enum class Term {
    kNone,
    kChange,         // three.js: adds the largest change of any component to perceptual roughness
    kVariance,       // Filament: increases alpha^2 by 2 `variance` times the sum of the squares of both changes, but
                     // at most by `limit`
    kPerceptual,     // Godot: increases the square of perceptual roughness by the same amount
    kGreaterChange,  // Babylon.js: uses the greater change c. Under lights, roughness is at least cbrt(c^2). For
                     // reflections, 3/4 of c is added to alpha
  };
  int anisotropy_max = 1;
  double roughness_least = 0.0;  // minimum of perceptual roughness
  Term term = Term::kNone;
  bool rebuilds_z = false;  // true if z of normals is computed from x and y
  bool is_of_map = false;   // true if the term uses mapped normals instead of the mesh's normals
  double variance = 0.0, limit = 1.0;
};

const EngineFilter& filter_of(Engine engine);

/// Perceptual roughness under lights and for reflections of the surroundings.
struct EngineRoughness {
  double lights = 1.0, surroundings = 1.0;
};
/// `along_x` and `along_y` are the changes of the normal from pixel to pixel, in view space.
EngineRoughness engine_roughness(const EngineFilter& filter, double roughness, const glm::dvec3& along_x,
                                 const glm::dvec3& along_y);

}  // namespace multum
