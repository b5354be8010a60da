// SPDX-License-Identifier: Apache-2.0
// Distant light from all directions: radiance over latitude and longitude.
#pragma once

#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace multum {

/// Row 0 is the upward direction, +Y. The middle column is -Z, with +X to its right. Values are linear and row-major.
struct EnvironmentMap {
  int width = 0;
  int height = 0;
  std::vector<glm::vec3> texels;
};

/// Returns a unit direction. `s` and `t` are 0..1 across the map.
glm::dvec3 environment_direction(double s, double t);
/// Returns (s, t) of a unit direction.
glm::dvec2 environment_coordinates(const glm::dvec3& direction);
/// Returns the solid angle of a texel of row `y`.
double texel_solid_angle(int width, int height, int y);

/// Averages blocks of texels over solid angle. The result is at most `width` wide, and half as high as wide. A smaller
/// map stays unchanged.
EnvironmentMap shrink(const EnvironmentMap& map, int width);

}  // namespace multum
