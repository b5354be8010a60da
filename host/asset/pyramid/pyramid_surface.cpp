// SPDX-License-Identifier: Apache-2.0
#include "host/asset/pyramid/pyramid_surface.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/base/error.h"

namespace multum {
namespace {

constexpr int kSurfaceSideMax = 4096;

// Texels a side at a real level; a surface needs two points.
int points(int size, double d) {
  return std::clamp(static_cast<int>(std::lround(static_cast<double>(size) * std::exp2(-d))), 2, kSurfaceSideMax);
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
  const auto index = [&](int i, int j) {
    return static_cast<std::uint32_t>(std::clamp(j, 0, surface.rows - 1) * surface.columns +
                                      std::clamp(i, 0, surface.columns - 1));
  };
  for (int j = 0; j < surface.rows; ++j)
    for (int i = 0; i < surface.columns; ++i) {
      const glm::vec3 right = surface.positions[index(i + 1, j)] - surface.positions[index(i - 1, j)];
      const glm::vec3 up = surface.positions[index(i, j - 1)] - surface.positions[index(i, j + 1)];
      const glm::vec3 normal = glm::cross(right, up);
      const float size = glm::length(normal);
      surface.normals.push_back(size > 0.0f ? normal / size : glm::vec3(0.0f, 0.0f, 1.0f));
      if (i + 1 == surface.columns || j + 1 == surface.rows) continue;
      const std::uint32_t a = index(i, j), b = index(i + 1, j), below = index(i, j + 1), across = index(i + 1, j + 1);
      surface.indices.insert(surface.indices.end(), {below, across, b, below, b, a});
    }
  return surface;
}

}  // namespace multum
