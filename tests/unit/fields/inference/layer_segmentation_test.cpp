// SPDX-License-Identifier: Apache-2.0
// Tests that pictures which consist of known parts are separated into these parts, even if values are damaged. The
// bytes must not depend on the number of threads.
#include "host/fields/inference/mapping/layer_segmentation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace multum {
namespace {

using Colour = std::array<float, 3>;

// Holds a picture and the coverages of its objects. All pixels have the same colour unless a test changes them.
struct Picture {
  Picture(int w, int h, std::size_t object_count)
      : width(w),
        height(h),
        rgb(static_cast<std::size_t>(3 * w * h)),
        coverages(object_count, std::vector<float>(static_cast<std::size_t>(w * h))) {}
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y * width + x); }
  void set(int x, int y, Colour colour) {
    for (std::size_t i = 0; i < 3; ++i) rgb[3 * at(x, y) + i] = colour[i];
  }
  std::vector<ObjectLayer> segment(const SegmentationSettings& settings, SegmentationReport* report) const {
    SegmentationInput input{width, height, rgb, {}};
    for (const auto& coverage : coverages) input.coverages.emplace_back(coverage);
    return segment_layer(input, settings, report);
  }
  int width, height;
  std::vector<float> rgb;
  std::vector<std::vector<float>> coverages;
};

Colour colour_of(const ObjectLayer& layer, std::size_t pixel) {
  return {layer.rgb[3 * pixel], layer.rgb[3 * pixel + 1], layer.rgb[3 * pixel + 2]};
}

void expect_near(const Colour& found, const Colour& expected, float tolerance) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], tolerance) << "channel " << i;
}

constexpr Colour kRed{0.8f, 0.1f, 0.0f}, kBlue{0.1f, 0.2f, 0.9f}, kSky{0.3f, 0.6f, 0.7f};

// Makes object 0 left of a slanted edge, object 1 right of it, and the background above.
Picture two_flat_objects() {
  Picture picture(24, 20, 2);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const float left = std::clamp(8.3f + 0.37f * static_cast<float>(y) - static_cast<float>(x), 0.0f, 1.0f);
      const float below = std::clamp(static_cast<float>(y) - 4.6f, 0.0f, 1.0f);
      const std::array<float, 3> c = {left * below, (1.0f - left) * below, 1.0f - below};
      picture.coverages[0][picture.at(x, y)] = c[0];
      picture.coverages[1][picture.at(x, y)] = c[1];
      Colour mixed{};
      for (std::size_t i = 0; i < 3; ++i) mixed[i] = c[0] * kRed[i] + c[1] * kBlue[i] + c[2] * kSky[i];
      picture.set(x, y, mixed);
    }
  return picture;
}

TEST(LayerSegmentationTest, FlatObjectsGetTheirColoursBackAtMixedEdges) {
  const Picture picture = two_flat_objects();
  SegmentationReport report;
  const std::vector<ObjectLayer> layers = picture.segment({}, &report);
  ASSERT_EQ(layers.size(), 2u);
  std::size_t covered = 0;
  for (std::size_t object = 0; object < 2; ++object)
    for (std::size_t pixel = 0; pixel < layers[object].coverage.size(); ++pixel) {
      const float coverage = picture.coverages[object][pixel];
      EXPECT_EQ(layers[object].coverage[pixel], coverage >= 1.0f / 64 ? coverage : 0.0f);
      if (!(layers[object].coverage[pixel] > 0.0f)) continue;
      ++covered;
      expect_near(colour_of(layers[object], pixel), object == 0 ? kRed : kBlue, 2e-6f);
    }
  EXPECT_GT(covered, 300u);
  EXPECT_GT(report.mixed_pixels, 40u);
  EXPECT_EQ(report.unguided_pixels, 0u);
  EXPECT_EQ(report.clipped_values + report.not_finite_pixels + report.negative_pixels, 0u);
}

TEST(LayerSegmentationTest, WhollyCoveredPixelsKeepTheirBits) {
  Picture picture = two_flat_objects();
  picture.set(2, 15, {0.123f, 0.456f, 0.789f});
  picture.coverages[0][picture.at(2, 15)] = 0.9995f;
  const std::vector<ObjectLayer> layers = picture.segment({}, nullptr);
  EXPECT_EQ(colour_of(layers[0], picture.at(2, 15)), (Colour{0.123f, 0.456f, 0.789f}));
}

// Makes values near 0.5 with random coverages, so that all parts stay within 0..1.
Picture random_picture(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(0.45f, 0.55f), share(0.0f, 1.0f);
  Picture picture(33, 21, 3);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const std::size_t pixel = picture.at(x, y);
      picture.set(x, y, {value(random), value(random), value(random)});
      const auto whole = static_cast<std::size_t>(x / 9);  // 3 is the background
      if (share(random) < 0.4f) {
        if (whole < 3) picture.coverages[whole][pixel] = 1.0f;
        continue;
      }
      std::array<float, 4> c = {share(random), share(random), share(random), share(random)};
      const float sum = c[0] + c[1] + c[2] + c[3];
      for (std::size_t object = 0; object < 3; ++object) picture.coverages[object][pixel] = c[object] / sum;
    }
  return picture;
}

TEST(LayerSegmentationTest, PartsAddUpToThePicture) {
  const unsigned seed = 21;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Picture picture = random_picture(seed);
  // Without a background, the result holds all parts.
  for (std::size_t pixel = 0; pixel < picture.coverages[0].size(); ++pixel) {
    const float covered = picture.coverages[0][pixel] + picture.coverages[1][pixel] + picture.coverages[2][pixel];
    picture.coverages[2][pixel] += 1.0f - covered;
  }
  SegmentationSettings settings;
  settings.coverage_min = 0.0;
  SegmentationReport report;
  const std::vector<ObjectLayer> layers = picture.segment(settings, &report);
  for (std::size_t pixel = 0; pixel < picture.coverages[0].size(); ++pixel)
    for (std::size_t i = 0; i < 3; ++i) {
      float sum = 0.0f;
      for (const ObjectLayer& layer : layers) sum += layer.coverage[pixel] * layer.rgb[3 * pixel + i];
      ASSERT_NEAR(sum, picture.rgb[3 * pixel + i], 1e-5f) << "pixel " << pixel;
    }
  EXPECT_EQ(report.clamped_values, 0u);
  EXPECT_EQ(report.clipped_values, 0u);
  EXPECT_GT(report.mixed_pixels, 500u);
}

TEST(LayerSegmentationTest, DamagedPixelsAreRepairedFromTheirObjectAndCounted) {
  Picture picture = two_flat_objects();
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  picture.set(3, 12, {nan, 0.1f, 0.0f});
  picture.set(11, 12, {nan, 0.1f, 0.0f});  // this pixel is fully covered, but the mixed pixels next to it must not read
                                           // it
  picture.set(20, 10, {0.1f, infinity, 0.9f});
  picture.set(20, 11, {0.1f, -infinity, 0.9f});
  picture.set(4, 17, {0.8f, -0.5f, 0.0f});
  picture.set(5, 17, {0.8f, -0.0005f, 0.0f});  // this value is ringing, which is not an error
  picture.set(11, 8, {nan, nan, nan});         // this pixel is on the edge of both objects
  ASSERT_GT(picture.coverages[0][picture.at(11, 8)], 0.1f);
  ASSERT_GT(picture.coverages[1][picture.at(11, 8)], 0.1f);
  SegmentationReport report;
  const std::vector<ObjectLayer> layers = picture.segment({}, &report);
  ASSERT_EQ(picture.coverages[0][picture.at(11, 12)], 1.0f);
  ASSERT_LT(picture.coverages[0][picture.at(12, 12)], 0.9f);
  EXPECT_EQ(report.not_finite_pixels, 6u);
  EXPECT_EQ(report.negative_pixels, 1u);
  EXPECT_EQ(report.repaired_pixels, 7u);
  expect_near(colour_of(layers[0], picture.at(12, 12)), kRed, 2e-6f);
  EXPECT_EQ(report.dropped_pixels, 0u);
  expect_near(colour_of(layers[0], picture.at(3, 12)), kRed, 2e-6f);
  expect_near(colour_of(layers[1], picture.at(20, 10)), kBlue, 2e-6f);
  expect_near(colour_of(layers[1], picture.at(20, 11)), kBlue, 2e-6f);
  expect_near(colour_of(layers[0], picture.at(11, 8)), kRed, 1e-3f);
  expect_near(colour_of(layers[1], picture.at(11, 8)), kBlue, 1e-3f);
  EXPECT_NEAR(layers[0].rgb[3 * picture.at(4, 17) + 1], 0.1f, 0.05f);
  EXPECT_EQ(layers[0].rgb[3 * picture.at(5, 17) + 1], 0.0f);
  for (const ObjectLayer& layer : layers)
    for (const float value : layer.rgb) ASSERT_TRUE(value >= 0.0f && value <= 1.0f);
}

TEST(LayerSegmentationTest, WhatCannotBeRepairedIsDropped) {
  Picture picture(9, 9, 1);
  picture.coverages[0][picture.at(4, 4)] = 1.0f;
  picture.set(4, 4, {std::numeric_limits<float>::quiet_NaN(), 0.0f, 0.0f});
  SegmentationReport report;
  const std::vector<ObjectLayer> layers = picture.segment({}, &report);
  EXPECT_EQ(report.dropped_pixels, 1u);
  EXPECT_EQ(layers[0].coverage[picture.at(4, 4)], 0.0f);
  EXPECT_EQ(colour_of(layers[0], picture.at(4, 4)), (Colour{0.0f, 0.0f, 0.0f}));
}

TEST(LayerSegmentationTest, AnObjectOfMixedPixelsOnlyIsFoundAgainstItsSurroundings) {
  // A wire over a flat wall covers half of each pixel along it. The part of a pixel that is not the wall is the wire.
  Picture picture(20, 20, 2);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) {
      const bool wire = x == 10;
      picture.coverages[0][picture.at(x, y)] = wire ? 0.5f : 1.0f;
      picture.coverages[1][picture.at(x, y)] = wire ? 0.5f : 0.0f;
      Colour colour = kBlue;
      if (wire)
        for (std::size_t i = 0; i < 3; ++i) colour[i] = 0.5f * kBlue[i] + 0.5f * kRed[i];
      picture.set(x, y, colour);
    }
  SegmentationReport report;
  const std::vector<ObjectLayer> layers = picture.segment({}, &report);
  EXPECT_EQ(report.mixed_pixels, 40u);
  EXPECT_EQ(report.unguided_pixels, 20u);
  const std::size_t pixel = picture.at(10, 7);
  const Colour wall = colour_of(layers[0], pixel), wire = colour_of(layers[1], pixel), b = {0.45f, 0.15f, 0.45f};
  // For the wire, m is the pixel itself, so r = b - wall / 2 - b / 2 = (b - wall) / 2. Each part gets the share c / (2
  // c^2) = 1 of r.
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(0.5f * wall[i] + 0.5f * wire[i], b[i], 1e-6f);
    EXPECT_NEAR(wire[i], b[i] + 0.5f * (b[i] - kBlue[i]), 1e-5f)
        << "the wire's colour is closer to its own than the pixel is";
    EXPECT_NEAR(wall[i], kBlue[i] + 0.5f * (b[i] - kBlue[i]), 1e-5f);
  }
}

TEST(LayerSegmentationTest, TheKernelWidensWhereNothingWholeIsNear) {
  // The only fully covered pixel of object 0 is ten pixels away. A filter with sigma 4 reaches it, but a filter with a
  // sigma_max of 2 does not.
  Picture picture(24, 3, 2);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 24; ++x) {
      const float c = x == 2 ? 1.0f : x < 14 ? 0.5f : 0.0f;
      picture.coverages[0][picture.at(x, y)] = c;
      picture.coverages[1][picture.at(x, y)] = 1.0f - c;
      Colour colour;
      for (std::size_t i = 0; i < 3; ++i) colour[i] = c * kRed[i] + (1.0f - c) * kBlue[i];
      picture.set(x, y, colour);
    }
  SegmentationSettings settings;
  settings.sigma_max = 4.0;
  expect_near(colour_of(picture.segment(settings, nullptr)[0], picture.at(12, 1)), kRed, 1e-5f);
  settings.sigma_max = 2.0;
  SegmentationReport report;
  const Colour unguided = colour_of(picture.segment(settings, &report)[0], picture.at(12, 1));
  EXPECT_GT(report.unguided_pixels, 0u);
  EXPECT_LT(unguided[0], 0.7f);
}

TEST(LayerSegmentationTest, BrightAndNegativePartsAreLimitedAndCounted) {
  Picture picture = two_flat_objects();
  picture.set(3, 12, {5.0f, 0.1f, 1.5f});
  SegmentationReport report;
  const std::vector<ObjectLayer> layers = picture.segment({}, &report);
  EXPECT_EQ(report.clipped_values, 2u);
  EXPECT_EQ(colour_of(layers[0], picture.at(3, 12)), (Colour{1.0f, 0.1f, 1.0f}));
  // A black pixel on the edge would require negative light from both objects.
  Picture black = two_flat_objects();
  black.set(11, 8, {0.0f, 0.0f, 0.0f});
  const std::vector<ObjectLayer> parts = black.segment({}, &report);
  EXPECT_GE(report.clamped_values, 1u);
  for (const ObjectLayer& layer : parts)
    for (const float value : layer.rgb) ASSERT_GE(value, 0.0f);
}

TEST(LayerSegmentationTest, AnyNumberOfThreadsGivesTheSameBytes) {
  Picture picture = random_picture(4);
  picture.set(5, 5, {std::numeric_limits<float>::quiet_NaN(), 0.0f, 0.0f});
  picture.set(9, 9, {7.0f, -3.0f, 0.0f});
  picture.set(10, 9, {7.0f, 0.5f, 0.0f});
  SegmentationSettings settings;
  settings.threads = 1;
  SegmentationReport one;
  const std::vector<ObjectLayer> expected = picture.segment(settings, &one);
  EXPECT_GT(one.clipped_values + one.clamped_values, 0u);
  for (const int threads : {2, 3, 7}) {
    settings.threads = threads;
    SegmentationReport report;
    const std::vector<ObjectLayer> found = picture.segment(settings, &report);
    for (std::size_t object = 0; object < found.size(); ++object) {
      const ObjectLayer &a = found[object], &b = expected[object];
      EXPECT_EQ(std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof(float)), 0);
      EXPECT_EQ(std::memcmp(a.coverage.data(), b.coverage.data(), a.coverage.size() * sizeof(float)), 0);
    }
    EXPECT_EQ(std::memcmp(&report, &one, sizeof(report)), 0);
  }
}

TEST(LayerSegmentationTest, AnObjectHasALayerOnlyIfSomeOfItIsLit) {
  ObjectLayer layer{{0.0f, 1.0f}, {0.5f, 0.5f, 0.5f, 0.0f, 0.0003f, 0.0f}};
  EXPECT_TRUE(has_radiance(layer, 1.0));
  EXPECT_FALSE(has_radiance(layer, 2.0)) << "the bright pixel is not covered";
  layer.coverage[0] = 0.5f;
  EXPECT_FALSE(has_radiance(layer, 2.0)) << "half a silhouette pixel counts nothing next to whole pixels";
  layer.coverage[1] = 0.0f;
  EXPECT_TRUE(has_radiance(layer, 1.0)) << "without whole pixels it counts";
  layer.coverage[0] = 0.0f;
  EXPECT_FALSE(has_radiance(layer, 1.0));
}

// One bright pixel in a thousand is enough for a layer. Compression artefacts in as many pixels are not enough.
TEST(LayerSegmentationTest, SmallHighlightsAreALayerAndTracesAreNot) {
  ObjectLayer layer{std::vector<float>(1000, 1.0f), std::vector<float>(3000, 0.0f)};
  layer.rgb[1500] = 1.0f;
  EXPECT_TRUE(has_radiance(layer, 1.0));
  layer.rgb[1500] = 0.0015f;
  EXPECT_FALSE(has_radiance(layer, 1.0));
}

}  // namespace
}  // namespace multum
