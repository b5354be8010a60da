// SPDX-License-Identifier: Apache-2.0
// Rounds corners to 2^-14 of a pixel and tests edges exactly in whole numbers. No pixel around a corner is then missed
// or drawn twice. Rounded edge functions could not guarantee this. The rounding moves a silhouette by less than a
// ten-thousandth of a pixel. Depth is interpolated in double precision.
#include "host/fields/inference/mapping/item_buffer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "host/fields/inference/mapping/clip_polygon.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr std::int64_t kUnitsPerPixel = 1 << 14;
// Triangles are clipped this many pixels from the origin, well outside every picture. Differences of corners then stay
// below 2^30 units. Products of two differences, and the sums of these products, stay below 2^62.
constexpr double kGuardPixels = 1 << 15;

struct ScreenVertex {
  std::int64_t x, y;  // position in units, y downwards
  double depth_over_w, one_over_w;
};

struct Edge {
  std::int64_t step_x, step_y, value;  // steps per pixel, and the value at the centre of the first pixel
  std::int64_t bias;                   // -1 if pixels on the edge belong to the other triangle
};

// Computes twice the signed area of (a, b, p), which is positive inside if the triangle is clockwise on the screen (y
// downwards). A pixel on a shared edge belongs to one triangle only, by the top-left rule.
Edge make_edge(const ScreenVertex& a, const ScreenVertex& b, std::int64_t x, std::int64_t y) {
  const std::int64_t dx = b.x - a.x, dy = b.y - a.y;
  const bool is_top_left = dy < 0 || (dy == 0 && dx > 0);
  return {-dy * kUnitsPerPixel, dx * kUnitsPerPixel, dx * (y - a.y) - dy * (x - a.x), is_top_left ? 0 : -1};
}

ScreenVertex to_screen(const ClipVertex& vertex, int width, int height) {
  const double one_over_w = 1.0 / vertex.position.w;
  const double x = (0.5 + 0.5 * vertex.position.x * one_over_w) * width;
  const double y = (0.5 - 0.5 * vertex.position.y * one_over_w) * height;
  return {std::llround(x * static_cast<double>(kUnitsPerPixel)), std::llround(y * static_cast<double>(kUnitsPerPixel)),
          vertex.depth * one_over_w, one_over_w};
}

// Returns the first column whose pixel centres are at `unit` or to the right of it. For rows, returns the first row
// whose centres are at `unit` or below it.
int first_centre(std::int64_t unit) {
  const std::int64_t shifted = unit - kUnitsPerPixel / 2 + kUnitsPerPixel - 1;
  return static_cast<int>(shifted >= 0 ? shifted / kUnitsPerPixel : -1);
}

struct Item {
  std::int32_t object, triangle;
};

struct DepthBuffer {
  ItemBuffer items;
  std::vector<double> depth;
};

struct PixelBounds {
  int x_begin, x_end, y_begin, y_end;
};

// Returns the pixels whose centres may be in the triangle.
PixelBounds pixel_box(const std::array<ScreenVertex, 3>& v, const ItemBuffer& items) {
  const auto [x_low, x_high] = std::minmax({v[0].x, v[1].x, v[2].x});
  const auto [y_low, y_high] = std::minmax({v[0].y, v[1].y, v[2].y});
  return {std::max(0, first_centre(x_low)), std::min(items.width, first_centre(x_high + 1)),
          std::max(0, first_centre(y_low)), std::min(items.height, first_centre(y_high + 1))};
}

// `share` has one value per corner. No value is negative, and the sum is positive. z/w and 1/w are linear on the
// screen, even for an orthographic projection. Their quotient is a weighted mean of the corners' depths, so it stays in
// the range of these depths.
void draw_pixel(const std::array<ScreenVertex, 3>& v, const std::array<std::int64_t, 3>& share, Item item,
                std::size_t pixel, DepthBuffer* buffer) {
  double over_w = 0.0, depth = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    over_w += static_cast<double>(share[i]) * v[i].one_over_w;
    depth += static_cast<double>(share[i]) * v[i].depth_over_w;
  }
  depth /= over_w;
  if (!(depth < buffer->depth[pixel])) return;
  buffer->depth[pixel] = depth;
  buffer->items.depth[pixel] = static_cast<float>(depth);
  buffer->items.object[pixel] = item.object;
  buffer->items.triangle[pixel] = item.triangle;
}

void draw_triangle(std::array<ScreenVertex, 3> v, Item item, DepthBuffer* buffer) {
  const std::int64_t area = (v[1].x - v[0].x) * (v[2].y - v[0].y) - (v[1].y - v[0].y) * (v[2].x - v[0].x);
  if (area == 0) return;
  if (area < 0) std::swap(v[1], v[2]);
  const PixelBounds box = pixel_box(v, buffer->items);
  if (box.x_begin >= box.x_end || box.y_begin >= box.y_end) return;
  const std::int64_t x_first = box.x_begin * kUnitsPerPixel + kUnitsPerPixel / 2;
  const std::int64_t y_first = box.y_begin * kUnitsPerPixel + kUnitsPerPixel / 2;
  // Edge i is opposite corner i, so its value is the corner's share of the area.
  std::array<Edge, 3> edges = {make_edge(v[1], v[2], x_first, y_first), make_edge(v[2], v[0], x_first, y_first),
                               make_edge(v[0], v[1], x_first, y_first)};
  for (int y = box.y_begin; y < box.y_end; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(buffer->items.width);
    std::array<std::int64_t, 3> e = {edges[0].value, edges[1].value, edges[2].value};
    for (int x = box.x_begin; x < box.x_end; ++x) {
      if (((e[0] + edges[0].bias) | (e[1] + edges[1].bias) | (e[2] + edges[2].bias)) >= 0)  // no sign bit is set
        draw_pixel(v, e, item, row + static_cast<std::size_t>(x), buffer);
      for (std::size_t i = 0; i < 3; ++i) e[i] += edges[i].step_x;
    }
    for (Edge& edge : edges) edge.value += edge.step_y;
  }
}

void draw_object(const PlacedObject& object, std::int32_t number, const glm::dmat4& projection, DepthBuffer* buffer) {
  const ObjectMesh& mesh = *object.mesh;
  const int width = buffer->items.width, height = buffer->items.height;
  std::vector<ClipVertex> corners(mesh.positions.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec4 camera = object.object_to_camera * glm::dvec4(glm::dvec3(mesh.positions[i]), 1.0);
    corners[i] = {projection * camera, glm::dvec2(0.0), -camera.z};
  }
  const glm::dvec2 size(width, height);
  const auto guard = box_planes(-2.0 * kGuardPixels / size - 1.0, 2.0 * kGuardPixels / size + 1.0);
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const ClipPolygon polygon =
        clip_triangle({corners[mesh.indices[i]], corners[mesh.indices[i + 1]], corners[mesh.indices[i + 2]]}, guard);
    const Item item = {number, static_cast<std::int32_t>(i / 3)};
    for (std::size_t k = 2; k < polygon.count; ++k)
      draw_triangle({to_screen(polygon.vertices[0], width, height), to_screen(polygon.vertices[k - 1], width, height),
                     to_screen(polygon.vertices[k], width, height)},
                    item, buffer);
  }
}

}  // namespace

ItemBuffer draw_item_buffer(const std::vector<PlacedObject>& objects, const glm::dmat4& projection, int width,
                            int height) {
  MULTUM_CHECK(width >= 1 && width <= kItemBufferSideMax && height >= 1 && height <= kItemBufferSideMax);
  const std::size_t pixel_count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  DepthBuffer buffer;
  buffer.items.width = width;
  buffer.items.height = height;
  buffer.items.object.assign(pixel_count, -1);
  buffer.items.triangle.assign(pixel_count, -1);
  buffer.items.depth.assign(pixel_count, std::numeric_limits<float>::infinity());
  buffer.depth.assign(pixel_count, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < objects.size(); ++i)
    draw_object(objects[i], static_cast<std::int32_t>(i), projection, &buffer);
  return std::move(buffer.items);
}

std::vector<std::vector<float>> item_coverage(const ItemBuffer& items, int factor, int object_count) {
  MULTUM_CHECK(factor >= 1 && items.width % factor == 0 && items.height % factor == 0);
  const auto width = static_cast<std::size_t>(items.width / factor);
  const auto height = static_cast<std::size_t>(items.height / factor);
  std::vector<std::vector<float>> coverage(static_cast<std::size_t>(object_count),
                                           std::vector<float>(width * height, 0.0f));
  const auto step = static_cast<std::size_t>(factor);
  for (std::size_t i = 0; i < items.object.size(); ++i) {
    const std::size_t x = i % (width * step) / step, y = i / (width * step) / step;
    if (items.object[i] >= 0) coverage[static_cast<std::size_t>(items.object[i])][y * width + x] += 1.0f;
  }
  for (std::vector<float>& of_object : coverage)
    for (float& share : of_object) share /= static_cast<float>(factor * factor);
  return coverage;
}

}  // namespace multum
