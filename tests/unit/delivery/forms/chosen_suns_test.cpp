// SPDX-License-Identifier: Apache-2.0
// Tests that weighted lights represent all lights from above equally, whichever way they were chosen.
#include "host/delivery/forms/chosen_suns.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace multum::testing {
namespace {

// Returns the mean of weight * value(direction).
template <typename Value>
double mean_of(const std::vector<glm::dvec3>& normals, double alpha, const glm::dvec3& view, const Value& value) {
  constexpr std::uint64_t kSeeds = 60000;
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
    for (const WeightedSun& sun : choose_suns(normals, alpha, view, seed)) sum += sun.weight * value(sun.direction);
  return sum / static_cast<double>(kSeeds * kFormSuns);
}

TEST(ChosenSunsTest, WeightsReplaceTheChoice) {
  const glm::dvec3 up(0.0, 1.0, 0.0), side(1.0, 0.0, 0.0), front(0.0, 0.0, 1.0);
  const std::vector<glm::dvec3> tilted = {glm::normalize(up + side), glm::normalize(front - 0.3 * up), front};
  for (const double alpha : {0.05, 0.3})
    for (const glm::dvec3& view : {front, glm::normalize(front + up), glm::normalize(side - 0.2 * up)})
      for (const std::vector<glm::dvec3>& normals : {std::vector{up}, std::vector{front}, tilted}) {
        EXPECT_NEAR(mean_of(normals, alpha, view, [](const glm::dvec3&) { return 1.0; }), 1.0, 0.02);
        EXPECT_NEAR(mean_of(normals, alpha, view, [](const glm::dvec3& sun) { return sun.y; }), 0.5, 0.015);
        EXPECT_NEAR(mean_of(normals, alpha, view, [](const glm::dvec3& sun) { return sun.x; }), 0.0, 0.02);
      }
}

TEST(ChosenSunsTest, HalfOfTheLightsShowHighlights) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.1, 0.6, 1.0)), view(0.0, 0.0, 1.0);
  int near = 0, count = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed)
    for (const WeightedSun& sun : choose_suns({normal}, 0.05, view, seed)) {
      near += glm::dot(glm::normalize(sun.direction + view), normal) > 0.98 ? 1 : 0;
      ++count;
    }
  EXPECT_GT(near, 0.4 * count);
}

}  // namespace
}  // namespace multum::testing
