// SPDX-License-Identifier: Apache-2.0
// Follows the steps of section 3.4 in the paper's order. Departures:
// - Step 1 uses the extents of whole triangles in the item buffers, because a cut through a triangle's hidden part
//   would tear the triangle. A direction whose coordinates fill one period without a gap is periodic only if the
//   surface is connected across the seam.
// - If the largest singular value is below the threshold after step 2, the map is made smaller until it reaches the
//   threshold: the paper asks for as few samples as possible. Steps 3 and 4 only make the map larger.
// - Step 5 includes visible parts instead of whole triangles: most of a large wall may be hidden.
#include "host/fields/inference/mapping/texture_coordinates.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "host/fields/inference/mapping/isometric_map.h"
#include "host/fields/inference/mapping/visible_pixels.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

// The tolerance for finding gaps and periods. Float coordinates near 1 have an error of 2^-24, and exporters increase
// this error.
constexpr double kPeriodTolerance = 1e-5;

struct SeenMesh {
  const ObjectMesh& mesh;
  const std::vector<MappingView>& views;
  std::vector<VisiblePixels> pixels;             // one per view
  std::vector<std::uint32_t> visible_triangles;  // triangles visible in any view, in ascending order
};

SeenMesh look(const ObjectMesh& mesh, const std::vector<MappingView>& views) {
  SeenMesh scene{mesh, views, std::vector<VisiblePixels>(views.size()), {}};
  for_each_item(static_cast<int>(views.size()), 0, [&](int i) {
    const auto view = static_cast<std::size_t>(i);
    scene.pixels[view] = find_visible_pixels(mesh, views[view]);
  });
  for (const VisiblePixels& pixels : scene.pixels)
    for (const VisibleTriangle& visible : pixels.triangles) scene.visible_triangles.push_back(visible.triangle);
  std::sort(scene.visible_triangles.begin(), scene.visible_triangles.end());
  scene.visible_triangles.erase(std::unique(scene.visible_triangles.begin(), scene.visible_triangles.end()),
                                scene.visible_triangles.end());
  return scene;
}

struct Interval {
  double low, high;
};

Interval triangle_extent(const ObjectMesh& mesh, std::uint32_t triangle, glm::length_t direction) {
  Interval extent{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < 3; ++i) {
    const double at = static_cast<double>(mesh.uvs[mesh.indices[3 * std::size_t{triangle} + i]][direction]);
    extent = {std::min(extent.low, at), std::max(extent.high, at)};
  }
  return extent;
}

// Returns the middle of the largest gap between intervals on a circle of circumference 1, or nullopt if there is no
// gap.
std::optional<double> middle_of_gap(std::vector<Interval> intervals) {
  // The end of the covered part, starting from the previous period.
  double covered = -std::numeric_limits<double>::infinity();
  for (Interval& interval : intervals) {
    const double period = std::floor(interval.low);
    interval = {interval.low - period, interval.high - period};
    covered = std::max(covered, interval.high - 1.0);
  }
  std::sort(intervals.begin(), intervals.end(), [](Interval a, Interval b) { return a.low < b.low; });
  double gap = kPeriodTolerance;
  std::optional<double> middle;
  for (const Interval& interval : intervals) {
    if (interval.low - covered > gap) {
      gap = interval.low - covered;
      middle = 0.5 * (interval.low + covered);
    }
    covered = std::max(covered, interval.high);
  }
  return middle;
}

// Returns whether visible triangles meet across the seam. Two triangles meet there if they have vertices at the same
// place whose coordinates differ by whole periods in `direction` and are equal in the other direction. Places are
// compared with a tolerance of a millionth of the object's size.
bool is_joined(const SeenMesh& scene, glm::length_t direction) {
  struct Corner {
    glm::dvec3 place;
    glm::dvec2 uv;
  };
  double size = std::numeric_limits<double>::min();
  for (const glm::dvec3 p : scene.mesh.positions) size = std::max({size, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  std::vector<Corner> corners;
  for (const std::uint32_t triangle : scene.visible_triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t vertex = scene.mesh.indices[3 * std::size_t{triangle} + i];
      corners.push_back({glm::round(glm::dvec3(scene.mesh.positions[vertex]) * (1e6 / size)) + 0.0,
                         glm::dvec2(scene.mesh.uvs[vertex])});
    }
  // Sorts corners by place, then by the coordinate in the other direction, then by the coordinate in this direction.
  std::sort(corners.begin(), corners.end(), [&](const Corner& a, const Corner& b) {
    const auto key = [&](const Corner& c) {
      return std::tuple(c.place.x, c.place.y, c.place.z, std::round(c.uv[1 - direction] / kPeriodTolerance),
                        c.uv[direction]);
    };
    return key(a) < key(b);
  });
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Corner &a = corners[i - 1], &b = corners[i];
    const double apart = b.uv[direction] - a.uv[direction];
    if (a.place == b.place && std::abs(a.uv[1 - direction] - b.uv[1 - direction]) < kPeriodTolerance && apart > 0.5 &&
        std::abs(apart - std::round(apart)) < kPeriodTolerance)
      return true;
  }
  return false;
}

// Step 1: moves the branch cut in a periodic texture direction.
void cut_branch(const SeenMesh& scene, std::size_t direction, TextureMapping* mapping) {
  const auto axis = static_cast<glm::length_t>(direction);
  WrapMode* wrap = direction == 0 ? &mapping->wrap_s : &mapping->wrap_t;
  std::vector<Interval> intervals;
  Interval all{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const std::uint32_t triangle : scene.visible_triangles) {
    intervals.push_back(triangle_extent(scene.mesh, triangle, axis));
    all = {std::min(all.low, intervals.back().low), std::max(all.high, intervals.back().high)};
  }
  *wrap = WrapMode::kClamp;
  if (const std::optional<double> middle = middle_of_gap(intervals)) {
    mapping->has_cut[direction] = true;
    mapping->cut[direction] = *middle;
  } else if (all.high - all.low > 1.0 + kPeriodTolerance || is_joined(scene, axis)) {
    *wrap = WrapMode::kPeriodic;
  }
}

std::array<bool, 2> periodic_directions(const TextureMapping& mapping) {
  return {mapping.wrap_s == WrapMode::kPeriodic, mapping.wrap_t == WrapMode::kPeriodic};
}

// Step 2: finds the most isometric affine map in the least-squares sense (eq. 7), with texels of the screen's
// resolution. The search starts from a map R for which R^T R is the mean of S^T S over visible pixels, where S is the
// Jacobian from texture coordinates to the screen. The singular values of R are then the mean singular values of S,
// however the mesh scales u and v.
glm::dmat2 isometric_map(const SeenMesh& scene, bool is_diagonal) {
  glm::dmat2 mean(0.0);
  std::vector<IsometricEdge> edges;
  for (std::size_t view = 0; view < scene.views.size(); ++view) {
    append_isometric_edges(scene.mesh, scene.views[view], scene.pixels[view], &edges);
    for (const PixelRun& run : scene.pixels[view].runs)
      for (int x = run.x_begin; x < run.x_end; ++x) {
        const auto jacobian = uv_jacobian(scene.pixels[view].triangles[run.item], {x + 0.5, run.y + 0.5});
        if (!jacobian || std::abs(glm::determinant(*jacobian)) < std::numeric_limits<double>::min()) continue;
        const glm::dmat2 to_screen = glm::inverse(*jacobian);
        mean += glm::transpose(to_screen) * to_screen;
      }
  }
  std::size_t count = 0;
  for (const VisiblePixels& pixels : scene.pixels) count += pixels.count;
  mean /= static_cast<double>(count);
  // Cholesky decomposition: mean = R^T R with R upper triangular. The element b of R is zero if the map must stay
  // diagonal.
  glm::dmat2 start(0.0);
  start[0][0] = std::sqrt(mean[0][0]);
  start[1][0] = is_diagonal ? 0.0 : mean[1][0] / start[0][0];
  start[1][1] = std::sqrt(mean[1][1] - start[1][0] * start[1][0]);
  const double det = start[0][0] * start[1][1];
  if (!std::isfinite(det) || !(det > 0.0)) return glm::dmat2(1.0);  // only degenerate pixels
  IsometricSettings settings;
  settings.is_diagonal = is_diagonal;
  return fit_isometric_map(edges, start, settings);
}

struct Stretch {
  double largest = 0.0;            // singular value of the map from texels to pixels
  glm::dvec2 direction{1.0, 0.0};  // the right singular vector of `largest`, in texels
  std::size_t degenerate_pixels = 0;
};

// With B = d(texel)/d(pixel), the largest singular value of B^-1 is the reciprocal of the smallest singular value of B.
// The direction of this value in texels is the left singular vector of B, which is the eigenvector of B B^T. The
// smallest singular value is computed as |det B| divided by the largest one, which avoids cancellation.
Stretch view_stretch(const VisiblePixels& pixels, const glm::dmat2& map) {
  Stretch stretch;
  double squared = 0.0;
  for (const PixelRun& run : pixels.runs)
    for (int x = run.x_begin; x < run.x_end; ++x) {
      const auto jacobian = uv_jacobian(pixels.triangles[run.item], {x + 0.5, run.y + 0.5});
      const glm::dmat2 b = jacobian ? map * *jacobian : glm::dmat2(0.0);
      const double det = glm::determinant(b);
      const double p = b[0][0] * b[0][0] + b[1][0] * b[1][0], r = b[0][1] * b[0][1] + b[1][1] * b[1][1];
      const double q = b[0][0] * b[0][1] + b[1][0] * b[1][1];
      const double value = 0.5 * (p + r + std::sqrt((p - r) * (p - r) + 4.0 * q * q)) / (det * det);
      if (!std::isfinite(value)) {
        ++stretch.degenerate_pixels;
      } else if (value > squared) {
        squared = value;
        const double angle = 0.5 * std::atan2(2.0 * q, p - r);  // angle of the largest eigenvalue
        stretch.direction = {-std::sin(angle), std::cos(angle)};
      }
    }
  stretch.largest = std::sqrt(squared);
  return stretch;
}

Stretch largest_stretch(const SeenMesh& scene, const glm::dmat2& map) {
  std::vector<Stretch> views(scene.views.size());
  for_each_item(static_cast<int>(views.size()), 0, [&](int i) {
    const auto view = static_cast<std::size_t>(i);
    views[view] = view_stretch(scene.pixels[view], map);
  });
  Stretch all;
  for (const Stretch& stretch : views) {
    if (stretch.largest > all.largest) {
      all.largest = stretch.largest;
      all.direction = stretch.direction;
    }
    all.degenerate_pixels += stretch.degenerate_pixels;
  }
  return all;
}

// Returns the map with texels that are smaller by `factor` along `direction`. A diagonal map is scaled along the axis
// nearest to `direction`.
glm::dmat2 scale_along(const glm::dmat2& map, glm::dvec2 direction, double factor, bool is_diagonal) {
  if (is_diagonal)
    direction = std::abs(direction.x) >= std::abs(direction.y) ? glm::dvec2(1.0, 0.0) : glm::dvec2(0.0, 1.0);
  return (glm::dmat2(1.0) + (factor - 1.0) * glm::outerProduct(direction, direction)) * map;
}

// Steps 3 and 4: scales the map along the direction of maximal stretch until the stretch is within the threshold
// everywhere.
glm::dmat2 hold_stretch(const SeenMesh& scene, glm::dmat2 map, double threshold, bool is_diagonal,
                        TextureMapping* mapping) {
  constexpr int kRoundsMax = 100;  // in the paper, "usually a very small number"
  // The last percent of excess stretch, and any excess after the last round, is removed by scaling in all directions at
  // once.
  constexpr double kAlmost = 1.01;
  constexpr double kRounding = 1e-9;  // relative
  Stretch stretch = largest_stretch(scene, map);
  mapping->degenerate_pixels = stretch.degenerate_pixels;
  if (!(stretch.largest > 0.0)) return map;
  if (stretch.largest < threshold) return map * (stretch.largest / threshold);
  while (stretch.largest > threshold * (1.0 + kRounding)) {
    const double factor = stretch.largest / threshold;
    ++mapping->stretch_rounds;
    if (factor < kAlmost || mapping->stretch_rounds >= kRoundsMax) return map * factor;
    map = scale_along(map, stretch.direction, factor, is_diagonal);
    stretch = largest_stretch(scene, map);
  }
  return map;
}

struct Rectangle {
  glm::dvec2 low, high;
};

Rectangle bounds(const std::vector<glm::dvec2>& hull, const glm::dmat2& map) {
  Rectangle box{glm::dvec2(std::numeric_limits<double>::infinity()),
                glm::dvec2(-std::numeric_limits<double>::infinity())};
  for (const glm::dvec2 uv : hull) {
    const glm::dvec2 at = map * uv;
    box = {glm::min(box.low, at), glm::max(box.high, at)};
  }
  return box;
}

// Step 5: finds the bounding rectangle of least area. Tries directions that are half a degree apart, and then takes
// finer steps around the best one. The map is rotated only if this lowers the area. The area includes a margin of one
// texel, so that thin objects are not rotated needlessly.
glm::dmat2 rotate_to_least_area(const std::vector<glm::dvec2>& hull, const glm::dmat2& map) {
  constexpr int kDirections = 180, kRefinements = 4;
  constexpr double kGainMin = 1e-6;  // least decrease, as a fraction of the area
  const auto rotated = [&](double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return glm::dmat2(c, s, -s, c) * map;
  };
  const auto area = [&](double angle) {
    const Rectangle box = bounds(hull, rotated(angle));
    return (box.high.x - box.low.x + 1.0) * (box.high.y - box.low.y + 1.0);
  };
  double best = 0.0, least = area(0.0), step = 0.5 * std::numbers::pi / kDirections;
  for (int refinement = 0; refinement <= kRefinements; ++refinement) {
    const int reach = refinement == 0 ? kDirections / 2 : 10;
    const double middle = best;
    for (int i = -reach; i <= reach; ++i) {
      const double angle = middle + i * step, candidate = area(angle);
      if (candidate < least * (1.0 - kGainMin)) {
        least = candidate;
        best = angle;
      }
    }
    step *= 0.1;
  }
  return rotated(best);
}

// Step 6: returns the number of texels along one side. The number is at most side_max, and a power of two if requested.
int side_length(double texels, const AnimationTexture& texture) {
  constexpr double kRounding = 1e-6;  // rounding tolerance: 64.0000001 texels are 64 texels
  const int wanted = static_cast<int>(std::ceil(std::clamp(texels - kRounding, 1.0, double{1 << 20})));
  if (!texture.power_of_two) return std::min(wanted, texture.side_max);
  int side = 1;
  while (side < wanted && 2 * side <= texture.side_max) side *= 2;
  return side;
}

// Step 6: maps texels to 0..1. A clamped direction keeps half a texel free at both ends, so that bilinear filtering
// reads no texels beyond the border. Rounding up the number of texels only makes the texels smaller. A periodic
// direction spans exactly one period.
void set_resolution(const std::vector<glm::dvec2>& hull, const glm::dmat2& map, const AnimationTexture& texture,
                    TextureMapping* mapping) {
  const Rectangle box = bounds(hull, map);
  const auto is_periodic = periodic_directions(*mapping);
  std::array<int*, 2> sides = {&mapping->width, &mapping->height};
  mapping->linear = glm::dmat2(0.0);
  mapping->offset = glm::dvec2(0.0);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto axis = static_cast<glm::length_t>(i);
    if (is_periodic[i]) {
      *sides[i] = side_length(std::abs(map[axis][axis]) * texture.resolution_scale, texture);
      mapping->linear[axis][axis] = 1.0;
      continue;
    }
    const double extent = box.high[axis] - box.low[axis];
    const int side = side_length(extent * texture.resolution_scale + 1.0, texture);
    const double scale = extent > 0.0 ? (side - 1) / extent / side : 0.0;
    *sides[i] = side;
    for (glm::length_t column = 0; column < 2; ++column) mapping->linear[column][axis] = scale * map[column][axis];
    mapping->offset[axis] = 0.5 / side - scale * box.low[axis];
  }
}

std::vector<glm::dvec2> hull_of_views(const SeenMesh& scene, const TextureMapping& mapping) {
  std::vector<std::vector<glm::dvec2>> hulls(scene.views.size());
  for_each_item(static_cast<int>(hulls.size()), 0, [&](int i) {
    const auto view = static_cast<std::size_t>(i);
    hulls[view] = visible_hull(scene.mesh, scene.views[view], scene.pixels[view], [&](std::uint32_t triangle) {
      return cut_shift(scene.mesh.uvs, scene.mesh.indices, triangle, mapping);
    });
  });
  std::vector<glm::dvec2> points;
  for (const auto& hull : hulls) points.insert(points.end(), hull.begin(), hull.end());
  return convex_hull(std::move(points));
}

}  // namespace

TextureMapping optimise_texture_mapping(const ObjectMesh& mesh, const std::vector<MappingView>& views,
                                        const AnimationTexture& texture) {
  MULTUM_CHECK(texture.stretch_max > 0.0 && texture.resolution_scale > 0.0 && texture.side_max >= 1);
  TextureMapping mapping;
  const SeenMesh scene = look(mesh, views);
  for (const VisiblePixels& pixels : scene.pixels) mapping.visible_pixels += pixels.count;
  if (mapping.visible_pixels == 0) {
    mapping.width = mapping.height = 0;
    return mapping;
  }
  if (texture.wrap == wrap_mode_name(WrapMode::kPeriodic))
    for (std::size_t direction = 0; direction < 2; ++direction) cut_branch(scene, direction, &mapping);
  const auto is_periodic = periodic_directions(mapping);
  const bool is_diagonal = is_periodic[0] || is_periodic[1];
  glm::dmat2 map = isometric_map(scene, is_diagonal);
  map = hold_stretch(scene, map, texture.stretch_max, is_diagonal, &mapping);
  const std::vector<glm::dvec2> hull = hull_of_views(scene, mapping);
  if (!is_diagonal) map = rotate_to_least_area(hull, map);
  set_resolution(hull, map, texture, &mapping);
  const glm::dmat2 texels = glm::dmat2(mapping.width, 0.0, 0.0, mapping.height) * mapping.linear;
  mapping.stretch_max = largest_stretch(scene, texels).largest;
  return mapping;
}

}  // namespace multum
