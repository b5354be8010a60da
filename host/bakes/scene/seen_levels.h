// SPDX-License-Identifier: Apache-2.0
// Finds the mip levels of a map that a camera needs.
#pragma once

#include "host/bakes/scene/scene_file.h"

namespace multum {

/// Returns the finest and the coarsest level that the default filter reads (tap_filter.h), from 0 to level_count - 1. A
/// corner pixel of a picture at the shortest distance, on a surface that faces the camera, covers the fewest texels.
/// The largest footprint belongs to a pixel in the middle of the picture, at the longest distance, on a surface that is
/// tilted by object.tilt_max.
struct SeenLevels {
  int first, last;
};
SeenLevels seen_levels(const SceneCamera& camera, const SceneObject& object, int map_width, int level_count);

}  // namespace multum
