// SPDX-License-Identifier: Apache-2.0
#include "tests/gl/test_maps.h"

#include <cmath>
#include <numbers>

namespace multum::gl {
namespace {

std::size_t texel_count(int size) { return static_cast<std::size_t>(size) * static_cast<std::size_t>(size); }

MovmfLevel make_level(int size, std::size_t lobe_count, bool coloured) {
  MovmfLevel level;
  level.width = level.height = size;
  level.lobes.assign(lobe_count, std::vector<glm::vec4>(texel_count(size)));
  if (coloured) level.colours.assign(lobe_count, std::vector<glm::vec3>(texel_count(size)));
  return level;
}

}  // namespace

TestMap make_flat_map(int size) {
  TestMap map;
  map.image = {size, size, std::vector<glm::vec3>(texel_count(size), {0.0f, 0.0f, 1.0f}), {}};
  for (int s = size; s > 0; s /= 2) {
    map.mipmap.levels.push_back(make_level(s, 1, false));
    for (glm::vec4& lobe : map.mipmap.levels.back().lobes[0]) lobe = {0.0f, 0.0f, 1.0f, 1.0f};
  }
  return map;
}

TestMap make_two_tilt_map(int size, double angle_degrees, StorageEncoding encoding, bool coloured) {
  const double angle = angle_degrees * std::numbers::pi / 180.0;
  const glm::vec3 tilts[2] = {{std::sin(angle), 0.0, std::cos(angle)}, {-std::sin(angle), 0.0, std::cos(angle)}};
  const glm::vec3 colours[2] = {{0.9f, 0.1f, 0.1f}, {0.1f, 0.1f, 0.9f}};
  TestMap map;
  map.mipmap.encoding = encoding;
  map.image.width = map.image.height = size;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      map.image.normals.push_back(tilts[(x + y) % 2]);
      if (coloured) map.image.albedo.push_back(colours[(x + y) % 2]);
    }
  for (int s = size; s > 0; s /= 2) {
    map.mipmap.levels.push_back(make_level(s, 2, coloured));
    MovmfLevel& level = map.mipmap.levels.back();
    for (std::size_t i = 0; i < texel_count(s); ++i)
      for (std::size_t j = 0; j < 2; ++j) {
        const std::size_t columns = static_cast<std::size_t>(s);
        const float amplitude = s < size ? 0.5f : (i % columns + i / columns) % 2 == j ? 1.0f : 0.0f;
        level.lobes[j][i] = amplitude * glm::vec4(tilts[j], 1.0f);
        if (coloured) level.colours[j][i] = amplitude * colours[j];
      }
  }
  return map;
}

}  // namespace multum::gl
