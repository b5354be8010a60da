// SPDX-License-Identifier: Apache-2.0
// Finds the mip levels of a map that a camera needs.
#pragma once

#include "host/bakes/scene/scene_file.h"

namespace multum {

/// The finest and the coarsest level that the default filter reads (host/formats/asset/tap_filter.h), from 0 to
/// level_count - 1. A pixel in a corner of the picture, closest to the surface and facing it, covers the fewest
/// texels. A pixel in the middle, farthest from a surface that is seen at object.tilt_max, covers the most.
struct SeenLevels {
  int first, last;
};
SeenLevels seen_levels(const SceneCamera& camera, const SceneObject& object, int map_width, int level_count);

}  // namespace multum
