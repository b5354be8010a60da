// SPDX-License-Identifier: Apache-2.0
// Makes pixels that show a plane at many tilts or a sphere, for maps without a model. Each pixel has its own view and
// shows its own part of the map, so that a few pixels cover the whole map.
#pragma once

#include <cstddef>
#include <vector>

#include "host/delivery/forms/model_pictures.h"

namespace multum {

/// Returns pictures of one pixel each. `distance` is the number of texels per pixel, a power of two from 1 on. For each
/// pixel, the actual number differs from `distance` by up to half an octave. `shape` is "plane" (seen from above),
/// "tilted plane" or "sphere". A sphere repeats the map twice around it. If a map is so small that a sphere would have
/// only a few pixels, there are no pictures.
std::vector<ModelPicture> simple_views(int width, int height, std::size_t pixels_per_view);

}  // namespace multum
