// SPDX-License-Identifier: Apache-2.0
// Tests properties that every bake of any map must have: conservation, symmetry, and repeatability.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "host/bakes/movmf/movmf_bake.h"
#include "host/bakes/movmf/start_memory.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/formats/testmap/four_quarter_map.h"
#include "tests/fixtures/test_device.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::test_device;

NormalMap random_map(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  return testing::make_map(width, height, [&](int, int) {
    const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24 * 2.0 - 1.0; };
    const double x = uniform(), y = uniform();
    return glm::normalize(glm::dvec3(x, y, 0.2 + std::abs(uniform())));
  });
}

// The brightness increases with the z of the normal.
ColourMap grey_albedo(const NormalMap& map) {
  ColourMap albedo;
  albedo.width = map.width;
  albedo.height = map.height;
  albedo.r = albedo.g = albedo.b = map.z;
  return albedo;
}

MovmfMipmap bake(const NormalMap& map, const MovmfSettings& settings, const ColourMap* albedo = nullptr) {
  FitReport report;
  MovmfMipmap mipmap = bake_movmf(test_device(), map, albedo, settings, report, nullptr);
  EXPECT_EQ(report.nonfinite, 0u);
  return mipmap;
}

bool same_pixels(const MovmfMipmap& a, const MovmfMipmap& b) {
  for (std::size_t l = 0; l < a.levels.size(); ++l)
    for (std::size_t j = 0; j < a.levels[l].lobes.size(); ++j)
      if (std::memcmp(a.levels[l].lobes[j].data(), b.levels[l].lobes[j].data(),
                      a.levels[l].lobes[j].size() * sizeof(glm::vec4)) != 0)
        return false;
  return true;
}

class BakePropertyTest : public ::testing::TestWithParam<std::pair<int, int>> {};
INSTANTIATE_TEST_SUITE_P(Sizes, BakePropertyTest,
                         ::testing::Values(std::pair{64, 64}, std::pair{128, 32}, std::pair{50, 37}, std::pair{1, 100},
                                           std::pair{100, 1}, std::pair{1, 1}, std::pair{3, 3}, std::pair{2, 1}));

// The amplitudes sum to 1, and the vectors a_j r_j sum to the mean normal of the covered texels, because filtering and
// fitting conserve both sums.
TEST_P(BakePropertyTest, AmplitudesAndMeanNormalsAreConserved) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 11);
  const MovmfMipmap mipmap = bake(map, {});
  ASSERT_EQ(static_cast<int>(mipmap.levels.size()), mip_level_count(width, height));
  glm::dvec3 mean(0.0);
  for (std::size_t i = 0; i < map.x.size(); ++i) mean += glm::dvec3(map.x[i], map.y[i], map.z[i]);
  mean /= static_cast<double>(map.x.size());
  for (const MovmfLevel& level : mipmap.levels) {
    glm::dvec4 level_mean(0.0);
    for (std::size_t i = 0; i < level.lobes[0].size(); ++i) {
      glm::dvec4 sum(0.0);
      for (const auto& lobe : level.lobes) sum += glm::dvec4(lobe[i]);
      EXPECT_NEAR(sum.w, 1.0, 1e-5) << level.width << " x " << level.height << " texel " << i;
      level_mean += sum / static_cast<double>(level.lobes[0].size());
    }
    // The texels of a level cover equal areas, so the mean over a level is the mean of the map.
    EXPECT_LT(glm::length(glm::dvec3(level_mean) - mean), 2e-5) << level.width << " x " << level.height;
  }
}

TEST_P(BakePropertyTest, IdenticalRunsGiveIdenticalBytes) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 12);
  EXPECT_TRUE(same_pixels(bake(map, {}), bake(map, {})));
}

// No level depends on a finer level.
TEST_P(BakePropertyTest, LevelsFromTheFirstOnAreTheSameBytes) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 15);
  ColourMap albedo = grey_albedo(map);
  const MovmfMipmap whole = bake(map, {}, &albedo);
  for (int first_level = 1; first_level < mip_level_count(width, height); ++first_level) {
    MovmfSettings settings;
    settings.first_level = first_level;
    const MovmfMipmap coarse = bake(map, settings, &albedo);
    MovmfMipmap dropped = whole;
    drop_finer_levels(dropped, first_level);
    EXPECT_EQ(coarse.header.first_level, first_level);
    EXPECT_EQ(movmf_content_hash(coarse, 1), movmf_content_hash(dropped, 1)) << first_level;
    EXPECT_TRUE(coarse.levels[0].lobes[0].empty());
  }
}

TEST_P(BakePropertyTest, ScalarVariantGivesTheSameBytes) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 13);
  const MovmfMipmap vectors = bake(map, {});
  test_device().set_shape(LaunchShape::of_accelerator(test_device().info()));
  EXPECT_TRUE(same_pixels(vectors, bake(map, {})));
  test_device().set_shape(LaunchShape::of(test_device().info()));
}

// A rotation by 90 degrees is exact in floats, because it only swaps and negates numbers. It must rotate every lobe in
// the same way. The kernels do not prefer an axis, except that sums are rounded in the order x, y. Where a texel has no
// more normals than lobes (levels 0 and 1), two lobes may be equally good, and either may win. Rounding may also change
// the order of almost equally good candidates for the start of EM, so this test does not search for initial lobes.
void expect_lobes_turn(MovmfSettings settings) {
  settings.search_start = false;
  const NormalMap map = make_four_quarter_map(64, 3).normals;
  NormalMap turned = map;
  for (std::size_t i = 0; i < map.x.size(); ++i) {
    turned.x[i] = -map.y[i];
    turned.y[i] = map.x[i];
  }
  const MovmfMipmap straight = bake(map, settings), rotated = bake(turned, settings);
  for (std::size_t l = 0; l < straight.levels.size(); ++l) {
    // Returns the mean absolute difference between the values of a lobe after the rotation.
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t j = 0; j < straight.levels[l].lobes.size(); ++j)
      for (std::size_t i = 0; i < straight.levels[l].lobes[j].size(); ++i, ++count) {
        const glm::vec4 s = straight.levels[l].lobes[j][i], r = rotated.levels[l].lobes[j][i];
        sum += static_cast<double>(glm::length(r - glm::vec4(-s.y, s.x, s.z, s.w)));
      }
    EXPECT_LT(sum / static_cast<double>(count), l < 2 ? 1e-2 : 1e-4) << "level " << l;
  }
}

TEST(BakeRotationTest, RotatedNormalsGiveRotatedLobes) {
  MovmfSettings settings;
  make_reference(settings);
  expect_lobes_turn(settings);
}

TEST(BakeRotationTest, CondensedNormalsRotateToo) { expect_lobes_turn({}); }

// Returns how much the lobes of neighbouring columns differ, over all rows: the sum over lobes of |a mu| differences.
double column_difference(const MovmfLevel& level, int left, int right) {
  double sum = 0.0;
  for (const auto& lobe : level.lobes)
    for (int y = 0; y < level.height; ++y) {
      const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(level.width);
      sum += static_cast<double>(glm::length(glm::vec3(lobe[row + static_cast<std::size_t>(left)]) -
                                             glm::vec3(lobe[row + static_cast<std::size_t>(right)])));
    }
  return sum;
}

// The lobes of a periodic map are also aligned across its border, even if the width is odd and both columns have the
// same colour.
TEST(BakePeriodicTest, LobesAreAlikeAcrossTheBorder) {
  for (int width : {128, 100}) {
    // The lobes of two opposite facets with equal shares have changed places between the two borders, because the
    // assignment of lobes drifts along the map.
    std::mt19937 random(21);
    const NormalMap map = testing::make_map(width, 128, [&](int x, int) {
      const double noise = static_cast<double>(random() >> 8) * 0x1p-24 - 0.5;
      const double turn = 0.5 * (x + 0.5) / width + (random() % 2 == 0 ? 0.5 : 0.0) + 0.1 * noise;
      const double azimuth = 2.0 * std::numbers::pi * turn;
      return glm::dvec3(0.5 * std::cos(azimuth), 0.5 * std::sin(azimuth), std::sqrt(0.75));
    });
    const auto border_difference = [&](bool periodic) {
      MovmfSettings settings;
      settings.periodic_x = periodic;
      const MovmfMipmap mipmap = bake(map, settings);
      double border = 0.0;
      for (std::size_t l : {1u, 2u, 3u}) border += column_difference(mipmap.levels[l], mipmap.levels[l].width - 1, 0);
      return border;
    };
    EXPECT_LT(border_difference(true), 0.95 * border_difference(false)) << width;
  }
}

TEST_P(BakePropertyTest, LobeColoursSumToTheMeanColour) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 14);
  ColourMap albedo = grey_albedo(map);
  for (float& g : albedo.g) g = 0.25f;
  const MovmfMipmap mipmap = bake(map, {}, &albedo);
  double mean = 0.0;
  for (float z : map.z) mean += static_cast<double>(z) / static_cast<double>(map.z.size());
  for (const MovmfLevel& level : mipmap.levels) {
    double level_mean = 0.0;
    for (std::size_t i = 0; i < level.colours[0].size(); ++i) {
      double green = 0.0;
      for (const auto& colour : level.colours) {
        level_mean += static_cast<double>(colour[i].x) / static_cast<double>(level.colours[0].size());
        green += static_cast<double>(colour[i].y);
      }
      EXPECT_NEAR(green, 0.25, 1e-5);
    }
    EXPECT_NEAR(level_mean, mean, 2e-5);
  }
}

TEST(BakeOrderTest, ScanlineConservesTooAndDiffers) {
  const NormalMap map = make_four_quarter_map(64, 3).normals;
  MovmfSettings scanline;
  scanline.order = FitOrder::kScanline;
  const MovmfMipmap a = bake(map, {}), b = bake(map, scanline);
  EXPECT_FALSE(same_pixels(a, b));
  for (std::size_t i = 0; i < b.levels[2].lobes[0].size(); ++i) {
    float sum = 0.0f;
    for (const auto& lobe : b.levels[2].lobes) sum += lobe[i].w;
    EXPECT_NEAR(sum, 1.0f, 1e-5f);
  }
}

// If another bake of the map has found the initial lobes, they equal the initial lobes that this bake would find.
TEST(StartMemory, TakesTheSameStart) {
  const NormalMap map = random_map(24, 16, 11);
  StartMemory memory;
  MapInputs inputs;
  const PlaneStore planes = planes_of(map);
  inputs.normals = &planes;
  MovmfSettings two;
  two.lobe_count = 2;
  MovmfSettings refined = two;
  refined.refine = true;  // the trials of this bake are not refined
  MovmfSettings one_pass = two;
  one_pass.pass_count = 1;
  const auto check = [&](const MovmfSettings& settings, bool is_known) {
    FitReport report;
    const MovmfMipmap mipmap = bake_movmf(test_device(), inputs, settings, report, nullptr, &memory);
    EXPECT_TRUE(same_pixels(mipmap, bake(map, settings)));
    EXPECT_EQ(report.start_launches == 0, is_known);
    EXPECT_EQ(report.start_remembered.processor_seconds > 0.0, is_known);
  };
  check(two, false);
  check(two, true);
  check(refined, true);
  check(one_pass, false);  // the trials of this bake differ from those of earlier bakes
  check(one_pass, true);
}

}  // namespace
}  // namespace multum
