// SPDX-License-Identifier: Apache-2.0
// Knows how engines look up a material's textures, and what they add to its roughness where normals change from pixel
// to pixel.
#pragma once

#include <glm/vec3.hpp>

#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

struct EngineFilter {
  /// What widens highlights.
  enum class Term {
    kNone,
    kChange,         // three.js: the largest change of a component is added to perceptual roughness
    kVariance,       // `variance` of both changes, twice, up to `limit`, is added to alpha^2 (Filament)
    kPerceptual,     // the same to the square of perceptual roughness (Godot)
    kGreaterChange,  // of both changes: its root of 3 is the least roughness under lights, and three quarters of it
                     // are added to alpha of reflections (Babylon.js)
  };
  int anisotropy_max = 1;
  double roughness_least = 0.0;  // perceptual
  Term term = Term::kNone;
  bool rebuilds_z = false;  // of normals, from x and y
  bool is_of_map = false;   // the term is of normals with the map in them, not of the mesh's
  double variance = 0.0, limit = 1.0;
};

const EngineFilter& filter_of(Engine engine);

/// Perceptual roughness under lights, and of what the surroundings reflect.
struct EngineRoughness {
  double lights = 1.0, surroundings = 1.0;
};
/// `along_x`, `along_y`: what the normal changes by from pixel to pixel, in the space of the view.
EngineRoughness engine_roughness(const EngineFilter& filter, double roughness, const glm::dvec3& along_x,
                                 const glm::dvec3& along_y);

}  // namespace multum
