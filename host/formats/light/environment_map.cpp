// SPDX-License-Identifier: Apache-2.0
#include "host/formats/light/environment_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace multum {

glm::dvec3 environment_direction(double s, double t) {
  const double phi = 2.0 * std::numbers::pi * (s - 0.5), theta = std::numbers::pi * t;
  return {std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
}

glm::dvec2 environment_coordinates(const glm::dvec3& d) {
  return {0.5 + std::atan2(d.x, -d.z) / (2.0 * std::numbers::pi),
          std::acos(std::clamp(d.y, -1.0, 1.0)) / std::numbers::pi};
}

double texel_solid_angle(int width, int height, int y) {
  const double top = std::numbers::pi * y / height, bottom = std::numbers::pi * (y + 1) / height;
  return 2.0 * std::numbers::pi / width * (std::cos(top) - std::cos(bottom));
}

EnvironmentMap shrink(const EnvironmentMap& map, int width) {
  const int factor = (map.width + width - 1) / width;
  if (factor <= 1) return map;
  // If the size is not a multiple of the block size, the last block is smaller.
  EnvironmentMap small{(map.width + factor - 1) / factor, (map.height + factor - 1) / factor, {}};
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      glm::dvec3 sum(0.0);
      double weight = 0.0;
      for (int v = y * factor; v < std::min((y + 1) * factor, map.height); ++v)
        for (int u = x * factor; u < std::min((x + 1) * factor, map.width); ++u) {
          const double angle = texel_solid_angle(map.width, map.height, v);
          sum += angle * glm::dvec3(map.texels[static_cast<std::size_t>(v) * static_cast<std::size_t>(map.width) +
                                               static_cast<std::size_t>(u)]);
          weight += angle;
        }
      small.texels.emplace_back(sum / weight);
    }
  return small;
}

}  // namespace multum
