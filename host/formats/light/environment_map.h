// SPDX-License-Identifier: Apache-2.0
// Distant light from everywhere: radiance over latitude and longitude.
#pragma once

#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace multum {

/// Row 0 is up, +Y; the middle column is -Z, to its right lies +X. Row-major, linear.
struct EnvironmentMap {
  int width = 0;
  int height = 0;
  std::vector<glm::vec3> texels;
};

/// Unit; `s`, `t`: 0..1 across the map.
glm::dvec3 environment_direction(double s, double t);
/// The (s, t) of a unit direction.
glm::dvec2 environment_coordinates(const glm::dvec3& direction);
/// The solid angle of a texel of row `y`.
double texel_solid_angle(int width, int height, int y);

/// Means over solid angle of blocks of texels: at most `width` wide, half as high. A map that is smaller stays.
EnvironmentMap shrink(const EnvironmentMap& map, int width);

}  // namespace multum
