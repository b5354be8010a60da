// SPDX-License-Identifier: Apache-2.0
// Clips convex polygons in homogeneous clip space, before the division by w (Sutherland and Hodgman 1974). Points
// behind the near plane have no place on the screen. All attributes are linear in clip space, with and without
// perspective.
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

/// Each plane adds at most one vertex: room for a triangle and the six planes below.
struct ClipPolygon {
  std::array<ClipVertex, 9> vertices;
  std::size_t count = 0;
};

/// A point is kept if dot(plane, position) >= 0.
using ClipPlane = glm::dvec4;

/// The near plane of OpenGL: z >= -w.
inline constexpr ClipPlane kNearPlane{0.0, 0.0, 1.0, 1.0};
/// Clipped before z >= -w, so that a matrix whose near plane is at or behind the eye cannot let w <= 0 pass.
inline constexpr double kWMin = 1e-9;

/// Returns the planes for x_low <= x / w <= x_high and y_low <= y / w <= y_high.
inline std::array<ClipPlane, 4> box_planes(glm::dvec2 low, glm::dvec2 high) {
  return {ClipPlane{1.0, 0.0, 0.0, -low.x}, ClipPlane{-1.0, 0.0, 0.0, high.x}, ClipPlane{0.0, 1.0, 0.0, -low.y},
          ClipPlane{0.0, -1.0, 0.0, high.y}};
}

namespace clip_detail {

// Always interpolates from the inside vertex to the outside vertex. Two triangles that share an edge then get the same
// bits for the new vertex, without a crack.
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

/// Returns the part of a triangle in front of the near plane and inside `planes` (at most four). Its count is 0 if
/// nothing is left.
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
