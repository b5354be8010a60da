// SPDX-License-Identifier: Apache-2.0
// Makes pixels that show a plane at many tilts or a sphere, for maps without a model. Each pixel has its own view and
// shows its own part of the map, so that a few pixels cover the whole map.
#pragma once

#include <cstddef>
#include <vector>

#include "host/delivery/forms/model_pictures.h"

namespace multum {

constexpr const char *kPlane = "plane", *kTiltedPlane = "tilted plane", *kSphere = "sphere";

/// A distance of the eye: the number of texels per pixel, and the value of ModelPicture::distance.
struct SeenDistance {
  double texels = 1.0, distance = 1.0;
};

struct ShapeViews {
  std::vector<SeenDistance> distances;
  std::vector<const char*> shapes;  // of the names above
  double radius = 0.0;              // radius of the sphere in texels
  double octaves = 0.0;             // the number of texels per pixel differs by up to half of this value from pixel to
                                    // pixel
  std::size_t pixels_per_view = 1;
  int samples_per_side = 8;  // samples per side of a pixel
  int threads = 1;
};

/// Returns pictures of one pixel each, by distance and shape. Pixels at the edge of a shape are omitted.
std::vector<ModelPicture> shape_views(int width, int height, const ShapeViews& views);

/// Returns pictures of one pixel each. `distance` is the number of texels per pixel, a power of two from 1 on. For each
/// pixel, the actual number differs from `distance` by up to half an octave. `shape` is "plane" (seen from above),
/// "tilted plane" or "sphere". A sphere repeats the map twice around it. If a map is so small that a sphere would have
/// only a few pixels, there are no pictures.
std::vector<ModelPicture> simple_views(int width, int height, std::size_t pixels_per_view);

}  // namespace multum
