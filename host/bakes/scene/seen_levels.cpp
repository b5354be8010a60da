// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/seen_levels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/formats/asset/tap_filter.h"

namespace multum {

SeenLevels seen_levels(const SceneCamera& camera, const SceneObject& object, int map_width, int level_count) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  const double half_height = std::tan(0.5 * camera.fov_degrees * kRadians);
  const double half_diagonal = half_height * std::hypot(1.0, static_cast<double>(camera.width) / camera.height);
  const double texels_per_metre = object.width > 0.0 ? map_width / object.width : object.texels_per_metre;
  const double pixel = 2.0 * half_height / camera.height;  // metres per pixel at a distance of one metre along the axis
  // For a point in the picture's corner, the distance along the axis is shorter than the distance along the line of
  // sight.
  const double finest = texels_per_metre * pixel * object.distance_min / std::hypot(1.0, half_diagonal);
  const double facing = texels_per_metre * pixel * object.distance_max;
  const double coarsest = facing / std::cos(object.tilt_max * kRadians);
  const auto clamped = [&](double level) {
    return static_cast<int>(std::clamp(level, 0.0, static_cast<double>(level_count - 1)));
  };
  const TapFilter filter;
  return {clamped(std::floor(filter.level(finest, finest))), clamped(std::ceil(filter.level(coarsest, facing)))};
}

}  // namespace multum
