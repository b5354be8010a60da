// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/chosen_suns.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

constexpr double kFromAbove = 0.5 / std::numbers::pi;  // density of all lights

// Returns the direction at an angle of acos(`height`) from a unit axis.
glm::dvec3 direction_around(const glm::dvec3& axis, double height, double turn) {
  const glm::dvec3 other = std::abs(axis.x) < 0.8 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 0.0, 1.0);
  const glm::dvec3 side = glm::normalize(glm::cross(axis, other));
  const double across = std::sqrt(std::max(0.0, 1.0 - height * height));
  return height * axis + across * (std::cos(turn) * side + std::sin(turn) * glm::cross(axis, side));
}

// Returns the density of lights that are reflected at GGX facets around the normals.
double reflected_density(const std::vector<glm::dvec3>& normals, double alpha, const glm::dvec3& view,
                         const glm::dvec3& sun) {
  const glm::dvec3 half = glm::normalize(sun + view);
  double sum = 0.0;
  for (const glm::dvec3& normal : normals) {
    const double cosine = std::max(glm::dot(normal, half), 0.0), d = cosine * cosine * (alpha * alpha - 1.0) + 1.0;
    sum += alpha * alpha / (std::numbers::pi * d * d) * cosine;
  }
  return sum / static_cast<double>(normals.size()) / (4.0 * std::max(glm::dot(view, half), 1e-6));
}

}  // namespace

std::array<WeightedSun, kFormSuns> choose_suns(const std::vector<glm::dvec3>& normals, double alpha,
                                               const glm::dvec3& view, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::array<WeightedSun, kFormSuns> made;
  for (WeightedSun& sun : made) {
    const bool is_reflected = random.uniform() >= 0.5;
    const double u = random.uniform(), turn = 2.0 * std::numbers::pi * random.uniform();
    if (is_reflected) {
      const double height = std::sqrt((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u));
      const glm::dvec3 facet = direction_around(normals[random.next() % normals.size()], height, turn);
      const double towards = glm::dot(view, facet);
      if (towards <= 0.0) continue;  // the eye does not see this facet
      sun.direction = 2.0 * towards * facet - view;
    } else {
      sun.direction = direction_around({0.0, 1.0, 0.0}, u, turn);
    }
    if (sun.direction.y <= 0.0) continue;
    sun.weight = kFromAbove / (0.5 * kFromAbove + 0.5 * reflected_density(normals, alpha, view, sun.direction));
  }
  return made;
}

}  // namespace multum
