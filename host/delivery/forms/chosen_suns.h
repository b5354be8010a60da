// SPDX-License-Identifier: Apache-2.0
// Chooses directional lights for a pixel under a sky. Glints of smooth surfaces are rare and bright, so most lights
// would not show them. Half of the lights are therefore chosen among those whose highlight falls on the pixel (multiple
// importance sampling with a balance heuristic, Veach and Guibas 1995; GGX, Walter et al. 2007).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "host/delivery/forms/form_shading.h"

namespace multum {

/// A unit vector towards a light, and its density among all lights from above, divided by the density with which it was
/// chosen. The mean weight is 1.
struct WeightedSun {
  glm::dvec3 direction{0.0, 1.0, 0.0};
  double weight = 0.0;
};

/// `normals` are unit vectors around which highlights are expected, and `alpha` is the width of the highlights. `view`
/// is a unit vector towards the eye.
std::array<WeightedSun, kFormSuns> choose_suns(const std::vector<glm::dvec3>& normals, double alpha,
                                               const glm::dvec3& view, std::uint64_t seed);

}  // namespace multum
