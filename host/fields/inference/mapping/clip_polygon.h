// SPDX-License-Identifier: Apache-2.0
// Clips convex polygons in homogeneous clip space, before the division by w (Sutherland and Hodgman 1974), because
// points behind the near plane have no place on the screen. All attributes are linear in clip space, both with and
// without perspective.
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

/// A polygon with room for a triangle that is clipped by the six planes below. Each plane adds at most one vertex.
struct ClipPolygon {
  std::array<ClipVertex, 9> vertices;
  std::size_t count = 0;
};

/// A point is kept if dot(plane, position) >= 0.
using ClipPlane = glm::dvec4;

/// The near plane of OpenGL: z >= -w.
inline constexpr ClipPlane kNearPlane{0.0, 0.0, 1.0, 1.0};
/// The smallest w that is kept. This limit is applied before z >= -w, because a matrix whose near plane is at or behind
/// the eye could let w <= 0 pass.
inline constexpr double kWMin = 1e-9;

/// Returns the planes for x_low <= x / w <= x_high and y_low <= y / w <= y_high.
inline std::array<ClipPlane, 4> box_planes(glm::dvec2 low, glm::dvec2 high) {
  return {ClipPlane{1.0, 0.0, 0.0, -low.x}, ClipPlane{-1.0, 0.0, 0.0, high.x}, ClipPlane{0.0, 1.0, 0.0, -low.y},
          ClipPlane{0.0, -1.0, 0.0, high.y}};
}

namespace clip_detail {

// Always interpolates from the inside vertex to the outside vertex. Two triangles that share an edge then get exactly
// the same new vertex, and no crack opens between them.
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

/// Returns the part of a triangle in front of the near plane and inside `planes` (at most four). The polygon's count is
/// 0 if no part is left.
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
