// SPDX-License-Identifier: Apache-2.0
// Measures the amount by which a texel format increases a picture's error. Shades a material's stored levels and its
// exact levels at many places and for many views, under a light and ambient light. Samples midway between two levels,
// like a trilinear sampler. Metalness comes from the texture. Surfaces other than metal scatter half of the incoming
// light. Errors of normals are most visible in metals and in smooth materials.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec4.hpp>

#include "host/delivery/export/uastc/level_file.h"

namespace multum {

/// The textures of `multum gltf`. All have the same level sizes.
struct MaterialLevels {
  const LevelFile* normal = nullptr;   // xyz, stored as 0 to 255
  const LevelFile* surface = nullptr;  // green: roughness, blue: metalness; if null, the constants below are used
  double roughness = 1.0;              // perceptual roughness
  double metalness = 1.0;
};

struct StorageError {
  double error = 0.0;  // increase of a picture's relative L1 error at the worst level
  int level = 0;

  void take(double other, int its_level) {
    if (other > error) error = other, level = its_level;
  }
};

/// Compares `stored` with `exact`, which are levels of the same material. Throws Error(kEnvironment) if a file cannot
/// be read.
StorageError storage_error(const MaterialLevels& exact, const MaterialLevels& stored);

/// The surface properties that apply to lobes. They are the same at every place.
struct LobeSurface {
  double roughness = 1.0;  // perceptual roughness
  double metalness = 1.0;
};

/// Returns the means of a material's finest level.
LobeSurface mean_surface(const MaterialLevels& levels);

/// The lobes of a level, [lobe][y * width + x] = (a r, a).
struct LobeLevel {
  int width = 0, height = 0;
  const std::vector<std::vector<glm::vec4>>* lobes = nullptr;
};

/// Compares stored lobes with exact lobes, level by level from the finest stored level. Renderers divide by the sum of
/// amplitudes.
StorageError lobe_storage_error(const std::vector<LobeLevel>& exact, const std::vector<LobeLevel>& stored,
                                const LobeSurface& surface);

}  // namespace multum
