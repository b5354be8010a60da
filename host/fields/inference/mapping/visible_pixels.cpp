// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/mapping/visible_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <utility>

#include "host/fields/inference/mapping/clip_polygon.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

std::array<ClipVertex, 3> triangle_corners(const ObjectMesh& mesh, const MappingView& view, std::uint32_t triangle) {
  std::array<ClipVertex, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t vertex = mesh.indices[3 * std::size_t{triangle} + i];
    const glm::dvec4 camera = view.object_to_camera * glm::dvec4(glm::dvec3(mesh.positions[vertex]), 1.0);
    corners[i] = {view.projection * camera, glm::dvec2(mesh.uvs[vertex]), -camera.z};
  }
  return corners;
}

// Returns pixel coordinates times w, with y downwards, and w.
glm::dvec3 homogeneous_pixels(const ClipVertex& vertex, const ItemBuffer& items) {
  const glm::dvec4& p = vertex.position;
  return {(0.5 * p.w + 0.5 * p.x) * items.width, (0.5 * p.w - 0.5 * p.y) * items.height, p.w};
}

glm::dvec2 to_pixels(const ClipVertex& vertex, const ItemBuffer& items) {
  const glm::dvec3 p = homogeneous_pixels(vertex, items);
  return glm::dvec2(p) / p.z;
}

// Texture coordinates are floats, so a degenerate triangle can get a small area from rounding errors. Such an area
// counts as zero.
bool is_line_in_texture(const std::array<ClipVertex, 3>& corners) {
  constexpr double kRounding = 0x1.0p-22;  // four times half a unit in the last place
  double side = 0.0, size = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    side = std::max(side, glm::distance(corners[i].uv, corners[(i + 1) % 3].uv));
    size = std::max({size, std::abs(corners[i].uv.x), std::abs(corners[i].uv.y)});
  }
  return std::abs(cross(corners[1].uv - corners[0].uv, corners[2].uv - corners[0].uv)) <= kRounding * size * side;
}

// The columns of `at` are the screen corners multiplied by w, with w itself in the last row. The columns of `value` are
// the required results multiplied by w. The map `value * at^-1` is linear in homogeneous coordinates, like perspective
// (Heckbert 1989).
VisibleTriangle make_visible_triangle(const ObjectMesh& mesh, const MappingView& view, std::uint32_t triangle) {
  const auto corners = triangle_corners(mesh, view, triangle);
  glm::dmat3 at, value;
  double scale = 1.0;
  for (glm::length_t i = 0; i < 3; ++i) {
    const ClipVertex& corner = corners[static_cast<std::size_t>(i)];
    at[i] = homogeneous_pixels(corner, *view.items);
    value[i] = glm::dvec3(corner.uv - corners[0].uv, 1.0);
    scale *= glm::length(at[i]);
  }
  constexpr double kEdgeOn = 1e-13;  // least area relative to the product of the corners; smaller areas are only
                                     // rounding errors
  const bool is_degenerate = is_line_in_texture(corners) || !(std::abs(glm::determinant(at)) > kEdgeOn * scale);
  return {triangle, is_degenerate, is_degenerate ? glm::dmat3(0.0) : value * glm::inverse(at)};
}

// Returns the part of a triangle that a run of pixels shows, with a margin of one pixel. The margin is needed because
// neighbouring pixels may have sub-pixels on the object although their centres are outside it. The part is clipped to
// the triangle, so that it stays bounded at a horizon.
ClipPolygon clip_to_run(const ObjectMesh& mesh, const MappingView& view, std::uint32_t triangle, const PixelRun& run) {
  const glm::dvec2 size(view.items->width, view.items->height);
  const glm::dvec2 low = glm::dvec2(run.x_begin - 1, run.y - 1) / size,
                   high = glm::dvec2(run.x_end + 1, run.y + 2) / size;
  const auto planes = box_planes({2.0 * low.x - 1.0, 1.0 - 2.0 * high.y}, {2.0 * high.x - 1.0, 1.0 - 2.0 * low.y});
  return clip_triangle(triangle_corners(mesh, view, triangle), planes);
}

}  // namespace

VisiblePixels find_visible_pixels(const ObjectMesh& mesh, const MappingView& view) {
  MULTUM_CHECK(view.items != nullptr && mesh.uvs.size() == mesh.positions.size());
  const ItemBuffer& items = *view.items;
  VisiblePixels pixels;
  for (int y = 0; y < items.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(items.width);
    for (int x = 0; x < items.width;) {
      const std::size_t first = row + static_cast<std::size_t>(x);
      const int begin = x;
      do ++x;
      while (x < items.width && items.object[row + static_cast<std::size_t>(x)] == items.object[first] &&
             items.triangle[row + static_cast<std::size_t>(x)] == items.triangle[first]);
      if (items.object[first] != view.object) continue;
      pixels.runs.push_back({begin, x, y, static_cast<std::uint32_t>(items.triangle[first])});
      pixels.count += static_cast<std::size_t>(x - begin);
    }
  }
  std::vector<std::uint32_t> seen;
  for (const PixelRun& run : pixels.runs) seen.push_back(run.item);
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  for (const std::uint32_t triangle : seen) pixels.triangles.push_back(make_visible_triangle(mesh, view, triangle));
  for (PixelRun& run : pixels.runs)
    run.item = static_cast<std::uint32_t>(std::lower_bound(seen.begin(), seen.end(), run.item) - seen.begin());
  return pixels;
}

std::optional<glm::dmat2> uv_jacobian(const VisibleTriangle& triangle, glm::dvec2 screen) {
  if (triangle.is_degenerate) return std::nullopt;
  const glm::dmat3& h = triangle.screen_to_uv;
  const glm::dvec3 value = h * glm::dvec3(screen, 1.0);
  if (!(value.z > 0.0)) return std::nullopt;  // behind the eye because of rounding at a corner on the near plane
  // Uses the quotient rule d(a / q) = (da - (a / q) dq) / q.
  const glm::dvec2 uv = glm::dvec2(value) / value.z;
  return glm::dmat2((glm::dvec2(h[0]) - uv * h[0].z) / value.z, (glm::dvec2(h[1]) - uv * h[1].z) / value.z);
}

void append_isometric_edges(const ObjectMesh& mesh, const MappingView& view, const VisiblePixels& pixels,
                            std::vector<IsometricEdge>* edges) {
  // Edges shorter than the sub-pixels of the usual supersampling do not affect visible detail. Foreshortened edges
  // would get unbounded weights in eq. 7, which divides by the shorter length.
  constexpr double kLengthMin = 0.25;
  const auto frustum = box_planes(glm::dvec2(-1.0), glm::dvec2(1.0));
  for (const VisibleTriangle& visible : pixels.triangles) {
    if (visible.is_degenerate) continue;
    const ClipPolygon polygon = clip_triangle(triangle_corners(mesh, view, visible.triangle), frustum);
    for (std::size_t k = 2; k < polygon.count; ++k) {
      const std::array<const ClipVertex*, 3> part = {&polygon.vertices[0], &polygon.vertices[k - 1],
                                                     &polygon.vertices[k]};
      std::array<glm::dvec2, 3> at;
      for (std::size_t i = 0; i < 3; ++i) at[i] = to_pixels(*part[i], *view.items);
      const double area = 0.5 * std::abs(cross(at[1] - at[0], at[2] - at[0]));
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t next = (i + 1) % 3;
        const double length = glm::distance(at[i], at[next]);
        const glm::dvec2 uv = part[next]->uv - part[i]->uv;
        if (length >= kLengthMin && area > 0.0 && glm::dot(uv, uv) > 0.0) edges->push_back({uv, length, area});
      }
    }
  }
}

std::vector<glm::dvec2> convex_hull(std::vector<glm::dvec2> points) {
  // Andrew 1979: computes the lower chain from left to right, then the upper chain from right to left.
  const auto before = [](glm::dvec2 a, glm::dvec2 b) { return std::pair(a.x, a.y) < std::pair(b.x, b.y); };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<glm::dvec2> hull;
  std::size_t keep = 1;
  const auto add = [&](glm::dvec2 point) {
    while (hull.size() > keep && cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0.0)
      hull.pop_back();
    hull.push_back(point);
  };
  for (const glm::dvec2 point : points) add(point);
  keep = hull.size();
  for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i]);
  hull.pop_back();  // the first point again
  return hull;
}

std::vector<glm::dvec2> visible_hull(const ObjectMesh& mesh, const MappingView& view, const VisiblePixels& pixels,
                                     const std::function<glm::dvec2(std::uint32_t triangle)>& shift) {
  constexpr std::size_t kPointsHeld = 1 << 16;  // one megabyte; more points are reduced to their hull
  std::vector<glm::dvec2> points;
  for (const PixelRun& run : pixels.runs) {
    const std::uint32_t triangle = pixels.triangles[run.item].triangle;
    const ClipPolygon polygon = clip_to_run(mesh, view, triangle, run);
    for (std::size_t i = 0; i < polygon.count; ++i) points.push_back(polygon.vertices[i].uv + shift(triangle));
    if (points.size() > kPointsHeld) points = convex_hull(std::move(points));
  }
  return convex_hull(std::move(points));
}

}  // namespace multum
