// SPDX-License-Identifier: Apache-2.0
// Pixels of a plane at many tilts and of a sphere, for maps that are on no model: each from its own side and with its
// own part of the map, so that few of them see all of it.
#pragma once

#include <cstddef>
#include <vector>

#include "host/delivery/forms/model_pictures.h"

namespace multum {

/// A picture of one pixel each; `distance`: texels a pixel, powers of two from 1 on, of which each pixel has up to half
/// an octave more or less. `shape`: "plane", seen from above, "tilted plane" or "sphere". A sphere has the map twice
/// round it. None of maps that are so small that a sphere would have but a few pixels.
std::vector<ModelPicture> simple_views(int width, int height, std::size_t pixels_per_view);

}  // namespace multum
