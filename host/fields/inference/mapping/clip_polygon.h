// SPDX-License-Identifier: Apache-2.0
// Clipping of convex polygons in homogeneous clip space, before the division by w (Sutherland and Hodgman 1974): what
// crosses the near plane has no place on the screen. All attributes are linear there, perspective or not.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <glm/ext/vector_double2.hpp>
#include <glm/ext/vector_double4.hpp>
#include <glm/geometric.hpp>

namespace multum {

struct ClipVertex {
  glm::dvec4 position{0.0};  // clip space
  glm::dvec2 uv{0.0};
  double depth = 0.0;  // along -z of camera space
};

/// Each plane adds at most one vertex: a triangle and the six planes below.
struct ClipPolygon {
  std::array<ClipVertex, 9> vertices;
  std::size_t count = 0;
};

/// A point is kept where dot(plane, position) >= 0.
using ClipPlane = glm::dvec4;

/// OpenGL's: z >= -w.
inline constexpr ClipPlane kNearPlane{0.0, 0.0, 1.0, 1.0};
/// Before z >= -w, since a matrix whose near plane lies at the eye or behind it must not let w <= 0 pass.
inline constexpr double kWMin = 1e-9;

/// The planes that bound x_low <= x / w <= x_high and y_low <= y / w <= y_high.
inline std::array<ClipPlane, 4> box_planes(glm::dvec2 low, glm::dvec2 high) {
  return {ClipPlane{1.0, 0.0, 0.0, -low.x}, ClipPlane{-1.0, 0.0, 0.0, high.x}, ClipPlane{0.0, 1.0, 0.0, -low.y},
          ClipPlane{0.0, -1.0, 0.0, high.y}};
}

namespace clip_detail {

// From the inside vertex to the outside one, whichever way round the edge is walked: two triangles that share an edge
// get the same bits for the new vertex, and no crack.
inline ClipVertex crossing(const ClipVertex& inside, const ClipVertex& outside, double d_inside, double d_outside) {
  const double t = d_inside / (d_inside - d_outside);
  return {inside.position + t * (outside.position - inside.position), inside.uv + t * (outside.uv - inside.uv),
          inside.depth + t * (outside.depth - inside.depth)};
}

template <typename Distance>
void clip_by(ClipPolygon* polygon, const Distance& distance) {
  const ClipPolygon in = *polygon;
  polygon->count = 0;
  for (std::size_t i = 0; i < in.count; ++i) {
    const ClipVertex &here = in.vertices[i], &next = in.vertices[(i + 1) % in.count];
    const double d_here = distance(here), d_next = distance(next);
    if (d_here >= 0.0) polygon->vertices[polygon->count++] = here;
    if (d_here >= 0.0 && d_next < 0.0) polygon->vertices[polygon->count++] = crossing(here, next, d_here, d_next);
    if (d_here < 0.0 && d_next >= 0.0) polygon->vertices[polygon->count++] = crossing(next, here, d_next, d_here);
  }
}

}  // namespace clip_detail

/// What of a triangle lies in front of the near plane and inside `planes` (at most four); count 0 where nothing does.
inline ClipPolygon clip_triangle(const std::array<ClipVertex, 3>& triangle, std::span<const ClipPlane> planes) {
  ClipPolygon polygon;
  polygon.count = 3;
  for (std::size_t i = 0; i < 3; ++i) polygon.vertices[i] = triangle[i];
  clip_detail::clip_by(&polygon, [](const ClipVertex& v) { return v.position.w - kWMin; });
  clip_detail::clip_by(&polygon, [](const ClipVertex& v) { return glm::dot(kNearPlane, v.position); });
  for (const ClipPlane& plane : planes)
    clip_detail::clip_by(&polygon, [&](const ClipVertex& v) { return glm::dot(plane, v.position); });
  return polygon;
}

}  // namespace multum
