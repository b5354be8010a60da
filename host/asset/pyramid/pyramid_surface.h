// SPDX-License-Identifier: Apache-2.0
// A surface of a chosen level of detail (Williams 1983, section 5): a grid of points sampled from a pyramid of heights
// or positions at any real level, as many as that level has texels.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/asset/pyramid/pyramid_sample.h"

namespace multum {

struct PyramidSurface {
  int columns = 0, rows = 0;
  std::vector<glm::vec3> positions, normals;  // row by row from the image's top; normals by differences along the grid
  std::vector<glm::vec2> uvs;                 // v grows upwards in the image
  std::vector<std::uint32_t> indices;         // three a triangle, counterclockwise from above (heights)
};

/// Heights: over the rectangle whose longer side is 1, about the origin, x to the image's right, y up, z the height.
/// Positions: as they are. Level `d` is held to those there are, and to grids of at most 4096 points a side.
PyramidSurface surface_at_level(const Pyramid& pyramid, double d);

}  // namespace multum
