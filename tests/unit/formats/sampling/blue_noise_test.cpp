// SPDX-License-Identifier: Apache-2.0
// Tests blue noise by Ulichney's criteria: all values occur equally often, and low frequencies have almost no power.
#include "host/formats/sampling/blue_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>
#include <vector>

#include "host/formats/sampling/void_and_cluster.h"

namespace multum {
namespace {

constexpr int kSide = kBlueNoiseSide;

std::vector<double> channel(std::size_t c) {
  std::vector<double> values;
  for (std::size_t i = c; i < blue_noise().size(); i += 4) values.push_back(blue_noise()[i] - 127.5);
  return values;
}

/// Returns the mean power of frequencies with 1 to `limit` periods across the mask, divided by the mean power of all
/// frequencies. White noise gives 1.
double low_power(const std::vector<double>& values, int limit) {
  double sum = 0.0, square = 0.0;
  int count = 0;
  for (const double value : values) square += value * value;
  for (int v = -limit; v <= limit; ++v)
    for (int u = -limit; u <= limit; ++u) {
      if ((u == 0 && v == 0) || u * u + v * v > limit * limit) continue;
      double real = 0.0, imaginary = 0.0;
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          const double phase = 2.0 * std::numbers::pi * (u * x + v * y) / kSide;
          const double value = values[static_cast<std::size_t>(y * kSide + x)];
          real += value * std::cos(phase);
          imaginary += value * std::sin(phase);
        }
      sum += real * real + imaginary * imaginary;
      ++count;
    }
  return sum / count / square;
}

TEST(BlueNoise, AllValuesAreAlikeOften) {
  ASSERT_EQ(blue_noise().size(), 4u * kSide * kSide);
  for (std::size_t c = 0; c < 4; ++c) {
    std::vector<int> counts(256);
    for (std::size_t i = c; i < blue_noise().size(); i += 4) ++counts[blue_noise()[i]];
    for (const int count : counts) ASSERT_EQ(count, kSide * kSide / 256) << "channel " << c;
  }
}

TEST(BlueNoise, LowFrequenciesAreMissing) {
  for (std::size_t c = 0; c < 4; ++c) {
    const double power = low_power(channel(c), kSide / 8);
    std::printf("channel %zu: power below 1/8 period per texel is %.4f times that of white noise\n", c, power);
    EXPECT_LT(power, 0.02);
    EXPECT_GT(low_power(channel(c), kSide / 2), 0.5) << "the power missing at low frequencies is at higher ones";
  }
}

TEST(BlueNoise, ChannelsHaveNothingToDoWithEachOther) {
  for (std::size_t c = 0; c < 4; ++c)
    for (std::size_t d = c + 1; d < 4; ++d) {
      const std::vector<double> a = channel(c), b = channel(d);
      double together = 0.0, square = 0.0;
      for (std::size_t i = 0; i < a.size(); ++i) {
        together += a[i] * b[i];
        square += a[i] * a[i];
      }
      EXPECT_LT(std::abs(together), 0.08 * square);  // five standard deviations of white noise
    }
}

TEST(VoidAndCluster, HasEveryRankOnceAtEverySide) {
  for (const int side : {8, 20}) {
    const std::vector<int> ranks = void_and_cluster(side, 7);
    const std::set<int> all(ranks.begin(), ranks.end());
    EXPECT_EQ(all.size(), ranks.size());
    EXPECT_EQ(*all.begin(), 0);
    EXPECT_EQ(*all.rbegin(), side * side - 1);
    EXPECT_EQ(ranks, void_and_cluster(side, 7));
    EXPECT_NE(ranks, void_and_cluster(side, 8));
  }
}

}  // namespace
}  // namespace multum
