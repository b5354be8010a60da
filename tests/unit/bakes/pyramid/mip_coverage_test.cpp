// SPDX-License-Identifier: Apache-2.0
// Compares box averages over covered texels with a brute-force computation, on a grid whose size is a multiple of both
// sizes.
#include "host/bakes/pyramid/mip_coverage.h"

#include <gtest/gtest.h>

#include <random>

namespace multum {
namespace {

// Cuts each texel of the finest level into to.width x to.height equal pieces, and counts each piece in the texel that
// contains its centre.
std::vector<double> brute_force(const std::vector<double>& plane, PlaneSize from, PlaneSize to) {
  std::vector<double> sums(static_cast<std::size_t>(to.width * to.height), 0.0);
  for (int y = 0; y < from.height * to.height; ++y)
    for (int x = 0; x < from.width * to.width; ++x) {
      const int source = y / to.height * from.width + x / to.width;
      const int target = y / from.height * to.width + x / from.width;
      sums[static_cast<std::size_t>(target)] += plane[static_cast<std::size_t>(source)];
    }
  for (double& sum : sums) sum /= static_cast<double>(from.width) * from.height;
  return sums;
}

TEST(MipCoverageTest, EqualsBruteForce) {
  const unsigned seed = 1;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> sizes(1, 23);
  std::uniform_real_distribution<double> values(-1.0, 1.0);
  for (int round = 0; round < 200; ++round) {
    const PlaneSize from = {sizes(random), sizes(random)};
    const PlaneSize to = {std::uniform_int_distribution<int>(1, from.width)(random),
                          std::uniform_int_distribution<int>(1, from.height)(random)};
    std::vector<double> plane(static_cast<std::size_t>(from.width * from.height));
    for (double& value : plane) value = values(random);
    const std::vector<double> expected = brute_force(plane, from, to);
    const std::vector<double> found = average_over_texels(plane, from, to, 2);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      ASSERT_NEAR(found[i], expected[i], 1e-12)
          << from.width << " x " << from.height << " to " << to.width << " x " << to.height << ", texel " << i;
  }
}

TEST(MipCoverageTest, WeightsSumToOneAndLoseNoTexel) {
  for (const PlaneSize from : {PlaneSize{1, 1}, PlaneSize{37, 20}, PlaneSize{64, 1}, PlaneSize{501, 3}})
    for (int level = 0; level < 9; ++level) {
      const PlaneSize to = {std::max(1, from.width >> level), std::max(1, from.height >> level)};
      const std::vector<double> ones(static_cast<std::size_t>(from.width * from.height), 1.0);
      for (const double value : average_over_texels(ones, from, to, 1)) EXPECT_NEAR(value, 1.0, 1e-13);
      // Each texel of the finest level counts once in every level, so the mean of the averages is the overall mean.
      std::vector<double> ramp(ones.size());
      for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<double>(i * i % 101);
      double mean = 0.0, mean_of_averages = 0.0;
      for (const double value : ramp) mean += value / static_cast<double>(ramp.size());
      const std::vector<double> averages = average_over_texels(ramp, from, to, 1);
      for (const double value : averages) mean_of_averages += value / static_cast<double>(averages.size());
      EXPECT_NEAR(mean_of_averages, mean, 1e-10 * mean);
    }
}

TEST(MipCoverageTest, DoesNotDependOnThreads) {
  std::vector<double> plane(37 * 20);
  for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = 1.0 / static_cast<double>(i + 3);
  EXPECT_EQ(average_over_texels(plane, {37, 20}, {9, 5}, 1), average_over_texels(plane, {37, 20}, {9, 5}, 4));
}

}  // namespace
}  // namespace multum
