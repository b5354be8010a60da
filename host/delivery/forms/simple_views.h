// SPDX-License-Identifier: Apache-2.0
// Makes pixels of a plane at many tilts and of a sphere, for maps without a model. Each pixel has its own view and its
// own part of the map, so that a few pixels cover the whole map.
#pragma once

#include <cstddef>
#include <vector>

#include "host/delivery/forms/model_pictures.h"

namespace multum {

/// Returns pictures of one pixel each. `distance` is the number of texels per pixel, a power of two from 1 on. The
/// distance of each pixel differs from this number by up to half an octave. `shape` is "plane" (seen from above),
/// "tilted plane" or "sphere". A sphere repeats the map twice around it. Maps that are too small for more than a few
/// pixels of a sphere have no pictures.
std::vector<ModelPicture> simple_views(int width, int height, std::size_t pixels_per_view);

}  // namespace multum
