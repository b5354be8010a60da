// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/simple_views.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <optional>

#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr double kSimpleTexelsMost = 32.0;  // texels per pixel; coarser views reuse the last level
constexpr double kSpherePixelsMin = 4.0;    // smallest radius of the sphere
constexpr double kSphereRim = 0.9;          // share of the sphere's area in the picture; the rest counts as edges
// Tilts of the plane seen from above, and of the tilted plane, in degrees.
constexpr double kTilts[] = {0.0, 35.0, 75.0};
constexpr double kPoleMost = 1.4;  // largest latitude on the sphere in radians, because tangent frames turn fast near
                                   // the poles
constexpr double kFlatRadius = 1000.0;  // radius in pixels from which a sphere is flat within a pixel
constexpr double kFar = 1e7;            // distance of the eye in texels, so large that all rays are parallel
constexpr double kTurn = 2.0 * std::numbers::pi;

// Generates numbers from 0 to 1 that are evenly spread over any number of axes (Kronecker's sequence).
class EvenNumbers {
 public:
  explicit EvenNumbers(std::size_t index) : index_(static_cast<double>(index)) {}
  double next() {
    // These are powers of the inverse of the root of x^9 = x + 1, which is Roberts's generalized golden ratio for eight
    // axes.
    power_ /= 1.085070245491451;
    const double value = 0.5 + index_ * power_;
    return value - std::floor(value);
  }

 private:
  double index_, power_ = 1.0;
};

// The viewing direction of a pixel. As for models, the surface is seen from all sides and slightly from above.
struct Side {
  glm::dvec3 towards_eye{0.0, 0.0, 1.0}, right{1.0, 0.0, 0.0}, up{0.0, 1.0, 0.0};
  double pixel = 1.0;  // width of a pixel in texels

  Side(double turn, double height, double pixel_texels) : pixel(pixel_texels) {
    towards_eye = glm::normalize(glm::dvec3(std::sin(kTurn * turn), 0.05 + 0.6 * height, std::cos(kTurn * turn)));
    right = glm::normalize(glm::cross(glm::dvec3(0.0, 1.0, 0.0), towards_eye));
    up = glm::cross(towards_eye, right);
  }
  // Returns the point of the picture plane that is `x` pixels to the right of the middle and `y` pixels below it.
  glm::dvec3 screen(double x, double y) const { return pixel * (x * right - y * up); }
};

// Returns the surface that a ray of a pixel hits, or nullopt if it hits none.
using Seen = std::function<std::optional<SurfacePoint>(double x, double y)>;

// Texels and parts of the map.
struct MapSize {
  double width, height;
  glm::dvec2 place(const glm::dvec2& first, double along, double up) const {
    return first + glm::dvec2(along / width, -up / height);
  }
};

Seen plane_of(const Side& side, const MapSize& map, bool is_tilted, EvenNumbers& numbers) {
  const double from = std::cos(kTilts[is_tilted ? 1 : 0] / 360.0 * kTurn),
               to = std::cos(kTilts[is_tilted ? 2 : 1] / 360.0 * kTurn);
  const double tilt = std::acos(from + numbers.next() * (to - from));
  const double leaning = kTurn * numbers.next();
  const glm::dvec3 across = std::cos(leaning) * side.right + std::sin(leaning) * side.up;
  const glm::dvec3 normal = std::cos(tilt) * side.towards_eye + std::sin(tilt) * across;
  const glm::dvec3 level = glm::normalize(glm::cross(normal, glm::dvec3(0.31, 0.83, -0.46)));
  const double turn = kTurn * numbers.next();
  const glm::dvec3 tangent = std::cos(turn) * level + std::sin(turn) * glm::cross(normal, level);
  const glm::dvec2 first(numbers.next(), numbers.next());
  return [=](double x, double y) -> std::optional<SurfacePoint> {
    const glm::dvec3 through = side.screen(x, y), bitangent = glm::cross(normal, tangent);
    const glm::dvec3 position =
        through - side.towards_eye * (glm::dot(through, normal) / glm::dot(side.towards_eye, normal));
    return SurfacePoint{position, normal, tangent, bitangent,
                        map.place(first, glm::dot(position, tangent), glm::dot(position, bitangent))};
  };
}

Seen sphere_of(const Side& side, const MapSize& map, double radius, EvenNumbers& numbers) {
  const double out = radius / side.pixel * std::sqrt(kSphereRim * numbers.next()), turn = kTurn * numbers.next();
  const glm::dvec2 middle(out * std::cos(turn), out * std::sin(turn)), first(numbers.next(), numbers.next());
  // The wrap is relative to the pixel's own place, so that the map has no seam.
  const auto position_at = [=](double x, double y) -> std::optional<glm::dvec3> {
    const glm::dvec3 through = side.screen(middle.x + x, middle.y + y);
    const double depth = radius * radius - glm::dot(through, through);
    if (depth <= 0.0) return std::nullopt;
    return through + side.towards_eye * std::sqrt(depth);
  };
  const glm::dvec3 at = position_at(0.0, 0.0).value_or(radius * side.towards_eye);
  const double turn_at = std::atan2(at.x, at.z);
  return [=](double x, double y) -> std::optional<SurfacePoint> {
    const std::optional<glm::dvec3> position = position_at(x, y);
    if (!position) return std::nullopt;
    const glm::dvec3 normal = *position / radius;
    const double rise = std::asin(std::clamp(normal.y, -1.0, 1.0)), round = std::atan2(normal.x, normal.z);
    if (std::abs(rise) > kPoleMost) return std::nullopt;
    const glm::dvec3 tangent(std::cos(round), 0.0, -std::sin(round));
    return SurfacePoint{*position, normal, tangent, glm::cross(normal, tangent),
                        map.place(first, radius * std::remainder(round - turn_at, kTurn), radius * rise)};
  };
}

// Returns nullopt if the pixel is on an edge. If `is_flat` is true, the samples are interpolated from the middle.
std::optional<ModelPixel> pixel_of(const Seen& seen, int samples_per_side, bool is_flat) {
  const auto middle = seen(0.0, 0.0), right = seen(0.5, 0.0), left = seen(-0.5, 0.0), below = seen(0.0, 0.5),
             above = seen(0.0, -0.5);
  if (!middle || !right || !left || !below || !above) return std::nullopt;
  ModelPixel made{*middle, *right - *left, *below - *above, {}, is_flat ? samples_per_side : 0};
  if (is_flat) return made;
  made.samples.reserve(size_of(samples_per_side * samples_per_side));
  for (int s = 0; s < samples_per_side * samples_per_side; ++s) {
    const glm::dvec2 at = ModelPixel::grid_place(s, samples_per_side);
    const auto sample = seen(at.x, at.y);
    if (!sample) return std::nullopt;
    made.samples.push_back(*sample);
  }
  return made;
}

}  // namespace

std::vector<ModelPicture> shape_views(int width, int height, const ShapeViews& views) {
  constexpr int kPicturesAtOnce = 64;
  const MapSize map{static_cast<double>(width), static_cast<double>(height)};
  std::vector<ModelPicture> made;
  for (const SeenDistance& seen : views.distances)
    for (const char* shape : views.shapes) {
      std::vector<ModelPicture> pictures(views.pixels_per_view);
      for_each_row_band(
          static_cast<int>(pictures.size()), kPicturesAtOnce, views.threads, [&](int, int begin, int end) {
            for (std::size_t i = size_of(begin); i < size_of(end); ++i) {
              EvenNumbers numbers(i);
              const double turn = numbers.next(), rise = numbers.next();
              const Side side(turn, rise, seen.texels * std::exp2(views.octaves * (numbers.next() - 0.5)));
              std::optional<ModelPixel> pixel =
                  pixel_of(shape == kSphere ? sphere_of(side, map, views.radius, numbers)
                                            : plane_of(side, map, shape == kTiltedPlane, numbers),
                           views.samples_per_side, shape == kSphere && views.radius >= kFlatRadius * side.pixel);
              if (!pixel) continue;
              ModelPicture& picture = pictures[i];
              picture.distance = seen.distance;
              picture.shape = shape;
              picture.eye = pixel->middle.position + kFar * side.towards_eye;
              picture.to_view = glm::transpose(glm::dmat3(side.right, side.up, side.towards_eye));
              picture.pixels.push_back(std::move(*pixel));
            }
          });
      for (ModelPicture& picture : pictures)
        if (!picture.pixels.empty()) made.push_back(std::move(picture));
    }
  return made;
}

std::vector<ModelPicture> simple_views(int width, int height, std::size_t pixels_per_view) {
  ShapeViews views{{}, {kPlane, kTiltedPlane, kSphere}, width / std::numbers::pi, 1.0, pixels_per_view};
  for (double texels = 1.0; texels <= kSimpleTexelsMost && views.radius >= kSpherePixelsMin * texels; texels *= 2.0)
    views.distances.push_back({texels, texels});
  return shape_views(width, height, views);
}

}  // namespace multum
