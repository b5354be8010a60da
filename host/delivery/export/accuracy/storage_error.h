// SPDX-License-Identifier: Apache-2.0
// Measures what a format of texels adds to a picture's error: shades a material's levels as they are stored and as they
// should be, at many places, filtered as a sampler does between two levels, under a light and what comes from all
// around, from many views.
// The material is metal where its texture says so, else half of the light that falls on it is scattered: an error of a
// normal shows most in metals, and in smooth ones.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec4.hpp>

#include "host/delivery/export/uastc/level_file.h"

namespace multum {

/// Textures as `multum gltf` has them. Their levels have the same sizes.
struct MaterialLevels {
  const LevelFile* normal = nullptr;   // xyz as 0 to 255
  const LevelFile* surface = nullptr;  // green roughness, blue metalness; null: those below everywhere
  double roughness = 1.0;              // perceptual
  double metalness = 1.0;
};

struct StorageError {
  double error = 0.0;  // added to the relative L1 error of a picture, of the level where it is largest
  int level = 0;

  void take(double other, int its_level) {
    if (other > error) error = other, level = its_level;
  }
};

/// Of `stored` against `exact`, the same material. Throws Error(kEnvironment) when a file cannot be read.
StorageError storage_error(const MaterialLevels& exact, const MaterialLevels& stored);

/// The surface under lobes, the same everywhere.
struct LobeSurface {
  double roughness = 1.0;  // perceptual
  double metalness = 1.0;
};

/// The means of a material's finest level.
LobeSurface mean_surface(const MaterialLevels& levels);

/// Lobes of a level, [lobe][y * width + x] = (a r, a).
struct LobeLevel {
  int width = 0, height = 0;
  const std::vector<std::vector<glm::vec4>>* lobes = nullptr;
};

/// The same of lobes, level after level from the finest that is stored. Renderers divide by the sum of amplitudes.
StorageError lobe_storage_error(const std::vector<LobeLevel>& exact, const std::vector<LobeLevel>& stored,
                                const LobeSurface& surface);

}  // namespace multum
