// SPDX-License-Identifier: Apache-2.0
// A surface of a chosen level of detail (Williams 1983, section 5): a grid of points sampled from a pyramid of heights
// or positions at any real level, as many as that level has texels; as corners of triangles or as control points of
// bicubic patches; and the level that its projection asks for.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/formats/asset/pyramid/pyramid_sample.h"

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

constexpr int kPatchStepsMax = 64;

/// The same points as control points of a uniform bicubic B-spline, `steps` (1..kPatchStepsMax) cells along each side
/// of a patch; fewer where the grid would have more than 4096 points a side. Normals are the spline's own. It ends in
/// the grid's border points; positions whose map wraps periodically are closed in that direction.
PyramidSurface patches_at_level(const Pyramid& pyramid, double d, int steps);

struct SurfaceView {
  glm::dvec3 eye{0.0};
  double focal_length = 1.0;  // in pixels: half the picture's height over the tangent of half the field of view
};

/// The level whose neighbouring points lie `spacing` pixels apart, in the root of the mean over the surface of a cell's
/// area, each cell as large as it is seen face-on: turning the surface changes no level. 0 where the finest are farther
/// apart. The area is that of a coarse level: bumps do not count.
double level_of_projection(const Pyramid& pyramid, const SurfaceView& view, double spacing);

}  // namespace multum
