// SPDX-License-Identifier: Apache-2.0
// Finds the visible pixels of one object in one picture, and how the object's texture coordinates change across each
// pixel. Texture mapping uses both (Hakura et al. 2000, section 3.4).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>

#include "host/fields/inference/mapping/isometric_map.h"
#include "host/fields/inference/mapping/mapping_view.h"
#include "host/formats/mesh/object_mesh.h"

namespace multum {

struct VisibleTriangle {
  std::uint32_t triangle;
  bool is_degenerate;  // has no Jacobian, because it has no area in the texture or on the screen
  // Maps (x, y, 1) in pixels to (q du, q dv, q). These are texture coordinates from the triangle's first corner, with
  // perspective.
  glm::dmat3 screen_to_uv;
};

/// The pixels x_begin to x_end - 1 of row y, which show one triangle.
struct PixelRun {
  int x_begin, x_end, y;
  std::uint32_t item;  // index into the triangles
};

struct VisiblePixels {
  std::vector<VisibleTriangle> triangles;  // in ascending order
  std::vector<PixelRun> runs;
  std::size_t count = 0;
};

VisiblePixels find_visible_pixels(const ObjectMesh& mesh, const MappingView& view);

/// Returns the Jacobian d(u, v) / d(x, y) at a point of the screen, or nullopt if it does not exist. The columns are
/// the derivatives by x and by y.
std::optional<glm::dmat2> uv_jacobian(const VisibleTriangle& triangle, glm::dvec2 screen);

/// Appends the edges of the visible triangles for eq. 7, after clipping with the viewing frustum. For a clipped
/// triangle, appends the edges of the triangles in its remaining part, because a triangle that fills the screen has no
/// other visible edges.
void append_isometric_edges(const ObjectMesh& mesh, const MappingView& view, const VisiblePixels& pixels,
                            std::vector<IsometricEdge>* edges);

/// Returns the corners of the points' convex hull, anticlockwise. There are fewer than three if all points are on a
/// line.
std::vector<glm::dvec2> convex_hull(std::vector<glm::dvec2> points);

/// Returns the hull of the texture coordinates of all visible parts. `shift(triangle)` moves each triangle.
std::vector<glm::dvec2> visible_hull(const ObjectMesh& mesh, const MappingView& view, const VisiblePixels& pixels,
                                     const std::function<glm::dvec2(std::uint32_t triangle)>& shift);

}  // namespace multum
