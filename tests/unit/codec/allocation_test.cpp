// SPDX-License-Identifier: Apache-2.0
// Tests how bytes are shared out: against every possible choice where there are few, and by its promises where there
// are many.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/base/split_mix.h"
#include "host/codec/allocation.h"

namespace multum {
namespace {

/// Convex curves, error = scale / (bytes + 1), and some points above them that are never worth taking.
std::vector<RateCurve> random_curves(SplitMix64& random, std::size_t count, std::size_t objects) {
  std::vector<RateCurve> curves(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double scale = std::exp(6.0 * random.uniform());
    curves[k].object = k % objects;
    double bytes = 0.0;
    for (int p = 0; p < 6; ++p) {
      curves[k].points.push_back({bytes, 100.0 * scale / (bytes + 20.0)});
      curves[k].points.push_back({bytes + 3.0, 100.0 * scale / (bytes + 20.0) + 1.0});
      bytes += 5.0 + 30.0 * random.uniform();
    }
  }
  return curves;
}

double least_error(const std::vector<RateCurve>& curves, double bytes) {
  double least = std::numeric_limits<double>::max();
  for (const auto& a : curves[0].points)
    for (const auto& b : curves[1].points)
      for (const auto& c : curves[2].points)
        if (a.bytes + b.bytes + c.bytes <= bytes) least = std::min(least, a.error + b.error + c.error);
  return least;
}

TEST(Allocation, IsNearTheBestOfAllChoices) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    SplitMix64 random(seed);
    const auto curves = random_curves(random, 3, 3);
    const double bytes = 300.0 * random.uniform();
    const Allocation allocation = allocate_bytes(curves, bytes);
    ASSERT_TRUE(allocation.is_met);
    EXPECT_LE(allocation.bytes, bytes);
    EXPECT_GE(allocation.error, least_error(curves, bytes) - 1e-9);
    // Equal slopes find every optimum on the convex hull; between two of them the greedy rest may miss a little.
    EXPECT_LE(allocation.error, least_error(curves, bytes) * 1.35);
  }
}

TEST(Allocation, MeetsBytesAndErrorsOfManyCurves) {
  SplitMix64 random(1);
  const auto curves = random_curves(random, 60, 6);
  double error_before = std::numeric_limits<double>::max();
  for (const double bytes : {0.0, 200.0, 1000.0, 3000.0, 20000.0}) {
    const Allocation allocation = allocate_bytes(curves, bytes);
    EXPECT_TRUE(allocation.is_met);
    EXPECT_LE(allocation.bytes, bytes);
    if (bytes > 0.0 && bytes < 5000.0) {
      EXPECT_GT(allocation.bytes, bytes - 40.0);  // steps are up to 35 bytes
    }
    EXPECT_LT(allocation.error, error_before);
    error_before = allocation.error;
    const Allocation reverse = allocate_error(curves, allocation.error);
    EXPECT_TRUE(reverse.is_met);
    EXPECT_LE(reverse.error, allocation.error);
    EXPECT_LE(reverse.bytes, allocation.bytes * 1.05 + 40.0);
  }
}

TEST(Allocation, SaysWhatCannotBe) {
  const std::vector<RateCurve> curves = {{{{10.0, 5.0}, {20.0, 1.0}}, 0}};
  EXPECT_FALSE(allocate_bytes(curves, 9.0).is_met);
  EXPECT_EQ(allocate_bytes(curves, 9.0).bytes, 10.0);
  EXPECT_FALSE(allocate_error(curves, 0.5).is_met);
  EXPECT_EQ(allocate_error(curves, 0.5).error, 1.0);
  EXPECT_EQ(allocate_error(curves, 5.0).bytes, 10.0);
}

TEST(Allocation, HoldsObjectsToAlpha) {
  SplitMix64 random(3);
  int held = 0;
  for (int round = 0; round < 30; ++round) {
    const auto curves = random_curves(random, 40, 4);
    const std::vector<double> pixels = {100.0, 70.0, 120.0, 70.0};  // smaller ones have as much error
    const double bytes = 900.0, alpha = 1.25;
    const Allocation plain = allocate_bytes(curves, bytes);
    const Allocation even = allocate_bytes_evenly(curves, pixels, bytes, alpha);
    std::vector<double> errors(4);
    for (std::size_t k = 0; k < curves.size(); ++k)
      errors[curves[k].object] += curves[k].points[even.points[k]].error / pixels[curves[k].object];
    if (!even.is_met) continue;
    ++held;
    for (const double error : errors) EXPECT_LE(error, alpha * plain.error / 360.0 + 1e-9);
    EXPECT_LE(even.bytes, bytes);
    EXPECT_GE(even.error, plain.error * 0.999);
  }
  EXPECT_GT(held, 5);
}

}  // namespace
}  // namespace multum
