// SPDX-License-Identifier: Apache-2.0
// Tests the transforms of images: cosines, wavelets, radiance, and mip levels.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "host/fields/codec/decoder/block_dct.h"
#include "host/fields/codec/decoder/mip_levels.h"
#include "host/fields/codec/decoder/radiance.h"
#include "host/fields/codec/decoder/wavelet_transform.h"
#include "host/foundation/base/half_bits.h"
#include "tests/unit/fields/codec/codec_test_data.h"

namespace multum {
namespace {

std::vector<float> noise(std::size_t count, SplitMix64& random) {
  std::vector<float> values(count);
  for (auto& value : values) value = static_cast<float>(random.uniform() - 0.5);
  return values;
}

double energy(const std::vector<float>& values) {
  double sum = 0.0;
  for (const float value : values) sum += static_cast<double>(value) * static_cast<double>(value);
  return sum;
}

TEST(BlockDct, IsOrthonormalAndComesBack) {
  SplitMix64 random(1);
  for (const int side : {8, 16, 32}) {
    const auto samples = noise(static_cast<std::size_t>(side * side), random);
    std::vector<float> coefficients(samples.size()), back(samples.size());
    forward_dct(side, samples, coefficients);
    EXPECT_NEAR(energy(coefficients), energy(samples), 1e-5 * energy(samples));
    inverse_dct(side, coefficients, back);
    for (std::size_t i = 0; i < back.size(); ++i) ASSERT_NEAR(back[i], samples[i], 1e-5f);
  }
}

TEST(BlockDct, KnowsItsFrequencies) {
  std::vector<float> samples(64), coefficients(64);
  for (std::size_t y = 0; y < 8; ++y)
    for (std::size_t x = 0; x < 8; ++x)
      samples[y * 8 + x] =
          static_cast<float>(std::cos(3.14159265358979 * (2.0 * static_cast<double>(x) + 1.0) * 3 / 16));
  forward_dct(8, samples, coefficients);
  for (std::size_t i = 0; i < 64; ++i) EXPECT_NEAR(coefficients[i], i == 3 ? 5.656854f : 0.0f, 1e-5f) << i;  // sqrt(32)
}

TEST(Wavelet, ComesBackForEverySize) {
  SplitMix64 random(2);
  for (const auto& [width, height] : std::vector<std::pair<std::size_t, std::size_t>>{
           {64, 64}, {37, 19}, {1, 50}, {50, 1}, {9, 8}, {8, 9}, {1, 1}, {7, 7}, {255, 17}, {130, 91}}) {
    SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
    const auto samples = noise(width * height, random);
    auto values = samples;
    forward_wavelet(width, height, values);
    inverse_wavelet(width, height, values);
    for (std::size_t i = 0; i < values.size(); ++i) ASSERT_NEAR(values[i], samples[i], 1e-5f);
  }
}

TEST(Wavelet, BandsCoverTheImageOnce) {
  for (const auto& [width, height] :
       std::vector<std::pair<std::size_t, std::size_t>>{{64, 64}, {37, 19}, {1, 50}, {9, 8}, {1, 1}, {129, 8}}) {
    std::vector<int> covered(width * height);
    for (const WaveletBand& band : wavelet_bands(width, height))
      for (std::size_t y = band.y; y < band.y + band.height; ++y)
        for (std::size_t x = band.x; x < band.x + band.width; ++x) ++covered.at(y * width + x);
    for (const int times : covered) ASSERT_EQ(times, 1);
  }
}

TEST(Wavelet, IsNearlyOrthonormalInEveryBand) {
  SplitMix64 random(3);
  for (const WaveletBand& band : wavelet_bands(200, 150)) {
    std::vector<float> values(200 * 150);
    for (std::size_t y = band.y; y < band.y + band.height; ++y)
      for (std::size_t x = band.x; x < band.x + band.width; ++x)
        values[y * 200 + x] = random.next() % 2 == 0 ? 1.0f : -1.0f;
    const double before = energy(values);
    inverse_wavelet(200, 150, values);
    EXPECT_NEAR(energy(values) / before, 1.0, 0.35) << band.depth << ' ' << band.kind;
  }
}

TEST(Wavelet, SmoothImagesHaveEmptyHighBands) {
  std::vector<float> values(64 * 64);
  for (std::size_t i = 0; i < values.size(); ++i)
    // The wavelet has four vanishing moments.
    values[i] = static_cast<float>(i % 64) * 0.5f + static_cast<float>(i / 64) * 0.25f;
  forward_wavelet(64, 64, values);
  for (std::size_t y = 36; y < 60; ++y)  // only away from the mirrored borders, where a ramp is not smooth
    for (std::size_t x = 36; x < 60; ++x) EXPECT_NEAR(values[y * 64 + x], 0.0f, 1e-4f);
}

TEST(HalfBits, ClampedAreTheNearestAsOthers) {
  SplitMix64 random(9);
  for (int i = 0; i < 2000000; ++i) {
    const auto bits = static_cast<std::uint32_t>(random.next() >> 32);
    const auto value = std::bit_cast<float>(bits);
    if (!(std::abs(value) <= 65504.0f)) continue;
    ASSERT_EQ(clamped_to_half(value), float_to_half(value)) << value;
  }
  EXPECT_EQ(clamped_to_half(-1e30f), 0xfbffu);
}

TEST(Radiance, IsThePowerOfGammaCodedValues) {
  EXPECT_EQ(radiance_of(255.0f), 1.0f);
  EXPECT_EQ(clamped_to_half(radiance_of(0.0f)), 0u);
  EXPECT_EQ(clamped_to_half(radiance_of(-100.0f)), 0u);
  EXPECT_EQ(clamped_to_half(radiance_of(-std::numeric_limits<float>::infinity())), 0u);
  EXPECT_EQ(clamped_to_half(radiance_of(std::numeric_limits<float>::infinity())), 0x7bffu);
  float last = 0.0f;
  for (float value = 1e-6f; value < 1e5f; value *= 1.0001f) {
    const float found = radiance_of(value);
    ASSERT_NEAR(static_cast<double>(found) / std::pow(static_cast<double>(value) / 255.0, 2.2), 1.0, 1e-6) << value;
    ASSERT_GE(found, last) << value;
    last = found;
  }
}

TEST(MipLevels, KeepTheMeanAndAreAdjoint) {
  SplitMix64 random(4);
  for (const auto& [width, height] :
       std::vector<std::pair<std::size_t, std::size_t>>{{8, 8}, {7, 5}, {1, 9}, {13, 1}, {1, 1}, {12, 10}}) {
    SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
    const std::size_t count = mip_texel_count(width, height);
    const auto finest = noise(3 * width * height, random);
    const auto levels = mip_levels(width, height, finest);
    ASSERT_EQ(levels.size(), 3 * count);
    for (std::size_t c = 0; c < 3; ++c) {
      double mean = 0.0;
      for (std::size_t i = c; i < finest.size(); i += 3) mean += static_cast<double>(finest[i]);
      EXPECT_NEAR(levels[3 * (count - 1) + c], mean / static_cast<double>(width * height), 1e-5);
    }
    const auto other = noise(3 * count, random);
    const auto down = handed_down(width, height, 3, other);
    double one = 0.0, two = 0.0;  // <mips(x), y> = <x, mips^T(y)>
    for (std::size_t i = 0; i < levels.size(); ++i)
      one += static_cast<double>(levels[i]) * static_cast<double>(other[i]);
    for (std::size_t i = 0; i < finest.size(); ++i)
      two += static_cast<double>(finest[i]) * static_cast<double>(down[i]);
    EXPECT_NEAR(one, two, 1e-4);
  }
}

}  // namespace
}  // namespace multum
