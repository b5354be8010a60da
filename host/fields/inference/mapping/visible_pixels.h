// SPDX-License-Identifier: Apache-2.0
// Finds what of one object is seen in one picture, and how its texture coordinates change across each pixel: what the
// steps of texture mapping read (Hakura et al. 2000, section 3.4).
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
  bool is_degenerate;  // without area in the texture or on the screen: no Jacobian
  // (x, y, 1) in pixels to (q du, q dv, q): texture coordinates from the triangle's first corner, perspective included.
  glm::dmat3 screen_to_uv;
};

/// Pixels x_begin to x_end - 1 of row y that show one triangle.
struct PixelRun {
  int x_begin, x_end, y;
  std::uint32_t item;  // index into the triangles
};

struct VisiblePixels {
  std::vector<VisibleTriangle> triangles;  // ascending
  std::vector<PixelRun> runs;
  std::size_t count = 0;
};

VisiblePixels find_visible_pixels(const ObjectMesh& mesh, const MappingView& view);

/// d(u, v) / d(x, y) at a point of the screen, columns by x and y; none where it does not exist.
std::optional<glm::dmat2> uv_jacobian(const VisibleTriangle& triangle, glm::dvec2 screen);

/// Edges of the visible triangles after clipping with the viewing frustum, for eq. 7. Where clipping cuts a triangle,
/// the edges of the triangles that what is left consists of: a triangle that fills the screen has no other edges there.
void append_isometric_edges(const ObjectMesh& mesh, const MappingView& view, const VisiblePixels& pixels,
                            std::vector<IsometricEdge>* edges);

/// The corners of the points' convex hull, anticlockwise; fewer than three where they lie on a line.
std::vector<glm::dvec2> convex_hull(std::vector<glm::dvec2> points);

/// The hull of the texture coordinates of all that is visible, each triangle's moved by `shift(triangle)`.
std::vector<glm::dvec2> visible_hull(const ObjectMesh& mesh, const MappingView& view, const VisiblePixels& pixels,
                                     const std::function<glm::dvec2(std::uint32_t triangle)>& shift);

}  // namespace multum
