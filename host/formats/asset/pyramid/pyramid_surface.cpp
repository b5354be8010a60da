// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/pyramid/pyramid_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr int kSurfaceSideMax = 4096;

// Returns the number of texels per side at a real level. It is at least 2, because a surface needs two points.
int points(int size, double d) {
  return std::clamp(static_cast<int>(std::lround(static_cast<double>(size) * std::exp2(-d))), 2, kSurfaceSideMax);
}

std::size_t grid_index(const PyramidSurface& surface, int i, int j) {
  return static_cast<std::size_t>(j) * static_cast<std::size_t>(surface.columns) + static_cast<std::size_t>(i);
}

void add_triangles(PyramidSurface& surface) {
  const auto index = [&](int i, int j) { return static_cast<std::uint32_t>(grid_index(surface, i, j)); };
  for (int j = 0; j + 1 < surface.rows; ++j)
    for (int i = 0; i + 1 < surface.columns; ++i) {
      const std::uint32_t a = index(i, j), b = index(i + 1, j), below = index(i, j + 1), across = index(i + 1, j + 1);
      surface.indices.insert(surface.indices.end(), {below, across, b, below, b, a});
    }
}

glm::vec3 unit_normal(const glm::vec3& right, const glm::vec3& up) {
  const glm::vec3 normal = glm::cross(right, up);
  const float size = glm::length(normal);
  return size > 0.0f ? normal / size : glm::vec3(0.0f, 0.0f, 1.0f);
}

// Points of a grid, with one extra point beyond every side. On a closed side, the extra point is the point from the
// other end. On an open side, it is the neighbour of the border point, mirrored about the border point. Then (p[-1] + 4
// p[0] + p[1]) / 6 = p[0], so the spline ends at the border.
class ControlGrid {
 public:
  ControlGrid(const PyramidSurface& surface, bool closed_s, bool closed_t)
      : surface_(surface), closed_s_(closed_s), closed_t_(closed_t) {}
  glm::dvec3 at(int i, int j) const {
    return along(i, surface_.columns, closed_s_, [&](int column) {
      return along(j, surface_.rows, closed_t_,
                   [&](int row) { return glm::dvec3(surface_.positions[grid_index(surface_, column, row)]); });
    });
  }

 private:
  template <typename Point>
  static glm::dvec3 along(int k, int count, bool closed, const Point& point) {
    if (closed) return point((k + count - 1) % (count - 1));  // the last point equals the first point
    if (k < 0) return 2.0 * point(0) - point(1);
    if (k >= count) return 2.0 * point(count - 1) - point(count - 2);
    return point(k);
  }
  const PyramidSurface& surface_;
  const bool closed_s_, closed_t_;
};

// Closes positions in directions in which the map is periodic. Heights always end at the border of the rectangle.
ControlGrid control_grid(const Pyramid& pyramid, const PyramidSurface& surface) {
  const BakedHeader& map = pyramid.header.map;
  const bool is_closable = pyramid.header.kind == PyramidKind::kPosition;
  return {surface, is_closable && map.wrap_s == WrapMode::kPeriodic, is_closable && map.wrap_t == WrapMode::kPeriodic};
}

// The four cubic B-splines that are non-zero within a span, and their derivatives.
struct CubicWeights {
  std::array<double, 4> value, slope;
};

CubicWeights cubic_weights(double t) {
  const double u = 1.0 - t;
  return {{u * u * u / 6.0, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0, (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
           t * t * t / 6.0},
          {-0.5 * u * u, 1.5 * t * t - 2.0 * t, 2.0 * u - 1.5 * u * u, 0.5 * t * t}};
}

// Returns the span and the weights of point `i` of a side with `steps` points per span.
std::pair<int, CubicWeights> span_of(int i, int steps, int count) {
  const int span = std::min(i / steps, count - 2);
  return {span, cubic_weights(static_cast<double>(i - span * steps) / steps)};
}

}  // namespace

PyramidSurface surface_at_level(const Pyramid& pyramid, double d) {
  const PyramidHeader& header = pyramid.header;
  MULTUM_CHECK(header.kind == PyramidKind::kHeight || header.kind == PyramidKind::kPosition);
  const double level = std::clamp(d, 0.0, header.level_count() - 1.0);
  const double longer = std::max(header.map.width, header.map.height);
  PyramidSurface surface;
  surface.columns = points(header.map.width, level);
  surface.rows = points(header.map.height, level);
  for (int j = 0; j < surface.rows; ++j)
    for (int i = 0; i < surface.columns; ++i) {
      const double s = static_cast<double>(i) / (surface.columns - 1), t = static_cast<double>(j) / (surface.rows - 1);
      const PyramidSample at = sample_pyramid(pyramid, s, t, level);
      surface.positions.push_back(
          header.kind == PyramidKind::kPosition
              ? glm::vec3(at[0], at[1], at[2])
              : glm::vec3((s - 0.5) * header.map.width / longer, (0.5 - t) * header.map.height / longer, at[0]));
      surface.uvs.emplace_back(s, 1.0 - t);
    }
  const ControlGrid grid = control_grid(pyramid, surface);
  for (int j = 0; j < surface.rows; ++j)
    for (int i = 0; i < surface.columns; ++i)
      surface.normals.push_back(unit_normal(glm::vec3(grid.at(i + 1, j) - grid.at(i - 1, j)),
                                            glm::vec3(grid.at(i, j - 1) - grid.at(i, j + 1))));
  add_triangles(surface);
  return surface;
}

PyramidSurface patches_at_level(const Pyramid& pyramid, double d, int steps) {
  MULTUM_CHECK(steps >= 1 && steps <= kPatchStepsMax);
  const PyramidSurface points = surface_at_level(pyramid, d);
  const ControlGrid control = control_grid(pyramid, points);
  const int most = (kSurfaceSideMax - 1) / (std::max(points.columns, points.rows) - 1);
  const int count = std::clamp(most, 1, steps);
  PyramidSurface surface;
  surface.columns = (points.columns - 1) * count + 1;
  surface.rows = (points.rows - 1) * count + 1;
  for (int j = 0; j < surface.rows; ++j)
    for (int i = 0; i < surface.columns; ++i) {
      const auto [column, across] = span_of(i, count, points.columns);
      const auto [row, down] = span_of(j, count, points.rows);
      glm::dvec3 position(0.0), right(0.0), below(0.0);
      for (int b = 0; b < 4; ++b)
        for (int a = 0; a < 4; ++a) {
          const glm::dvec3 point = control.at(column + a - 1, row + b - 1);
          const auto k = static_cast<std::size_t>(a), l = static_cast<std::size_t>(b);
          position += across.value[k] * down.value[l] * point;
          right += across.slope[k] * down.value[l] * point;
          below += across.value[k] * down.slope[l] * point;
        }
      surface.positions.emplace_back(position);
      surface.normals.push_back(unit_normal(glm::vec3(right), glm::vec3(-below)));
      surface.uvs.emplace_back(static_cast<double>(i) / (surface.columns - 1),
                               1.0 - static_cast<double>(j) / (surface.rows - 1));
    }
  add_triangles(surface);
  return surface;
}

double level_of_projection(const Pyramid& pyramid, const SurfaceView& view, double spacing) {
  MULTUM_CHECK(spacing > 0.0 && view.focal_length > 0.0);
  const BakedHeader& map = pyramid.header.map;
  constexpr double kCoarseSide = 64.0;  // points per side, which suffice to estimate distances across a surface
  const PyramidSurface coarse =
      surface_at_level(pyramid, std::max(0.0, std::log2(std::max(map.width, map.height) / kCoarseSide)));
  const auto at = [&](int i, int j) { return glm::dvec3(coarse.positions[grid_index(coarse, i, j)]); };
  double area = 0.0;
  for (int j = 0; j + 1 < coarse.rows; ++j)
    for (int i = 0; i + 1 < coarse.columns; ++i) {
      const glm::dvec3 a = at(i, j), b = at(i + 1, j), c = at(i, j + 1), e = at(i + 1, j + 1);
      const double size = 0.5 * glm::length(glm::cross(e - a, b - c));  // area of a quadrilateral, from its diagonals
      const glm::dvec3 away = 0.25 * (a + b + c + e) - view.eye;
      area += size * view.focal_length * view.focal_length / std::max(glm::dot(away, away), 1e-12);
    }
  const double finest = std::sqrt(area / ((std::max(map.width, 2) - 1.0) * (std::max(map.height, 2) - 1.0)));
  return finest > 0.0 ? std::clamp(std::log2(spacing / finest), 0.0, pyramid.header.level_count() - 1.0)
                      : pyramid.header.level_count() - 1.0;
}

}  // namespace multum
