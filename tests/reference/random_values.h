// SPDX-License-Identifier: Apache-2.0
// Random values that are the same with every standard library, whose distributions are not.
#pragma once

#include <cmath>
#include <random>

#include <glm/vec3.hpp>

namespace multum::testing {

/// 0 to 1, without 1, in steps of 2^-24.
inline double uniform24(std::mt19937& random) { return static_cast<double>(random() >> 8) * 0x1p-24; }

/// Even over the whole sphere.
inline glm::dvec3 random_direction(std::mt19937& random) {
  const double z = 2.0 * uniform24(random) - 1.0, phi = 2.0 * M_PI * uniform24(random), side = std::sqrt(1.0 - z * z);
  return {side * std::cos(phi), side * std::sin(phi), z};
}

}  // namespace multum::testing
