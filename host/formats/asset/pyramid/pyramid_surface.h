// SPDX-License-Identifier: Apache-2.0
// Surfaces of a chosen level of detail (Williams 1983, section 5). A grid of points is sampled from a pyramid of
// heights or positions at any real level, with as many points as the level has texels. The points are corners of
// triangles or control points of bicubic patches. Also finds the level of detail for a given projection.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/formats/asset/pyramid/pyramid_sample.h"

namespace multum {

struct PyramidSurface {
  int columns = 0, rows = 0;
  std::vector<glm::vec3> positions, normals;  // row by row from the top; normals are computed from differences
  std::vector<glm::vec2> uvs;                 // v grows upwards in the image
  std::vector<std::uint32_t> indices;         // three per triangle, counterclockwise from above (heights)
};

/// Samples a surface at level `d`, which is clamped to the existing levels and to at most 4096 points per side. Heights
/// form a surface over a rectangle about the origin whose longer side is 1. x points to the right of the image, y up,
/// and z is the height. Positions are used unchanged.
PyramidSurface surface_at_level(const Pyramid& pyramid, double d);

constexpr int kPatchStepsMax = 64;

/// Uses the points of surface_at_level() as control points of a uniform bicubic B-spline, with `steps`
/// (1..kPatchStepsMax) cells along each side of a patch. Uses fewer steps if the grid would exceed 4096 points per
/// side. Normals are exact for the spline. The spline ends at the border points of the grid. If the map is periodic in
/// a direction, positions are closed in this direction.
PyramidSurface patches_at_level(const Pyramid& pyramid, double d, int steps);

struct SurfaceView {
  glm::dvec3 eye{0.0};
  double focal_length = 1.0;  // in pixels: half the height of the picture / tan(half the field of view)
};

/// Returns the level at which neighbouring points are `spacing` pixels apart, as the root mean square over the surface.
/// Every cell counts with the size that it has when seen face-on, so turning the surface does not change the level.
/// Returns 0 if even the finest points are farther apart. The area is computed from a coarse level, so it does not
/// include bumps.
double level_of_projection(const Pyramid& pyramid, const SurfaceView& view, double spacing);

}  // namespace multum
