// SPDX-License-Identifier: Apache-2.0
// Maps made by a rule.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/image/colour_map.h"
#include "host/formats/image/normals/normal_map.h"
#include "tests/reference/random_values.h"

namespace multum::testing {

/// normal_at(x, y) as it is, unit or not; rows from the top.
inline NormalMap make_map(int width, int height, const std::function<glm::dvec3(int, int)>& normal_at) {
  NormalMap map;
  map.width = width;
  map.height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const glm::vec3 n(normal_at(x, y));
      map.x.push_back(n.x);
      map.y.push_back(n.y);
      map.z.push_back(n.z);
    }
  return map;
}

/// Normals evenly over the sphere from z_min to the pole.
inline NormalMap random_map(int width, int height, double z_min, unsigned seed) {
  std::mt19937 random(seed);
  return make_map(width, height, [&](int, int) {
    const double z = z_min + (1.0 - z_min) * uniform24(random), phi = 2.0 * M_PI * uniform24(random);
    return glm::dvec3(std::sqrt(1.0 - z * z) * std::cos(phi), std::sqrt(1.0 - z * z) * std::sin(phi), z);
  });
}

inline ColourMap random_colours(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  ColourMap map;
  map.width = width;
  map.height = height;
  for (int i = 0; i < width * height; ++i)
    for (std::vector<float>* plane : {&map.r, &map.g, &map.b}) plane->push_back(static_cast<float>(uniform24(random)));
  return map;
}

/// As a PNG of 16 bits stores it: 0.5 + 0.5 n, three codes a texel.
inline std::vector<std::uint16_t> normal_codes(const NormalMap& map) {
  std::vector<std::uint16_t> codes;
  for (std::size_t i = 0; i < map.x.size(); ++i)
    for (const float v : {map.x[i], map.y[i], map.z[i]})
      codes.push_back(static_cast<std::uint16_t>(std::lround((0.5 + 0.5 * static_cast<double>(v)) * 65535.0)));
  return codes;
}

}  // namespace multum::testing
