// SPDX-License-Identifier: Apache-2.0
// Compares kernels/moments.cl with averages in double precision. The sizes of levels nest or do not nest, and bands
// have any height.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include <glm/geometric.hpp>

#include "host/bakes/averages/moment_bake.h"
#include "host/foundation/base/error.h"
#include "host/lab/reference/moments.h"
#include "tests/fixtures/test_maps.h"
#include "tests/kernels/em_harness.h"

namespace multum {
namespace {

using testing::make_map;
using testing::random_colours;
using testing::random_map;
using testing::test_device;

MomentMipmap bake(const NormalMap& map, const ColourMap* albedo = nullptr, const AverageInputs& inputs = {}) {
  AverageReport report;
  return bake_moments(test_device(), map, albedo, inputs, report, nullptr);
}

// The kernel uses pairwise sums along a row of up to 2^15 texels and compensated sums over the rows, with two roundings
// at the ends. Each step has an error of about 2^-24 of the largest term that the texel covers.
constexpr double kMomentTolerance = 1.5e-6;

void expect_near_reference(const NormalMap& map, const ColourMap* albedo, const MomentMipmap& baked) {
  double slope_max = 1.0;
  for (std::size_t i = 0; i < map.x.size(); ++i)
    slope_max = std::max(slope_max, std::hypot(static_cast<double>(map.x[i]), static_cast<double>(map.y[i])) /
                                        std::max(static_cast<double>(map.z[i]), 0.05));
  ASSERT_EQ(static_cast<int>(baked.levels.size()), mip_level_count(map.width, map.height));
  for (std::size_t l = static_cast<std::size_t>(baked.header.first_level); l < baked.levels.size(); ++l) {
    const MomentLevel& level = baked.levels[l];
    ASSERT_EQ(level.slopes.size(), static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height));
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x) {
        const auto i =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(level.width) + static_cast<std::size_t>(x);
        const reference::TexelMoments m = reference::moments_of_texel(map, albedo, level.width, level.height, x, y);
        const SlopeMoments& found = level.slopes[i];
        const std::string where =
            "level " + std::to_string(l) + ", texel (" + std::to_string(x) + ", " + std::to_string(y) + ")";
        EXPECT_EQ(found.height, -1.0f) << where;
        EXPECT_NEAR(static_cast<double>(found.s), m.s, kMomentTolerance * slope_max) << where;
        EXPECT_NEAR(static_cast<double>(found.t), m.t, kMomentTolerance * slope_max) << where;
        EXPECT_NEAR(static_cast<double>(found.ss), m.ss, kMomentTolerance * slope_max * slope_max) << where;
        EXPECT_NEAR(static_cast<double>(found.tt), m.tt, kMomentTolerance * slope_max * slope_max) << where;
        EXPECT_NEAR(static_cast<double>(found.st), m.st, kMomentTolerance * slope_max * slope_max) << where;
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(static_cast<double>(level.normals[i][c]), m.normal[c], kMomentTolerance) << where;
          if (albedo == nullptr) continue;
          EXPECT_NEAR(static_cast<double>(level.colours[i][c]), m.colour[c], kMomentTolerance) << where;
        }
      }
  }
}

struct Size {
  int width, height;
};

void PrintTo(const Size& size, std::ostream* out) { *out << size.width << " x " << size.height; }

class MomentKernelTest : public ::testing::TestWithParam<Size> {};
INSTANTIATE_TEST_SUITE_P(Sizes, MomentKernelTest,
                         ::testing::Values(Size{1, 1}, Size{2, 2}, Size{1, 17}, Size{33, 1}, Size{16, 64}, Size{64, 16},
                                           Size{11, 7}, Size{3, 100}, Size{100, 3}, Size{63, 65}, Size{37, 128}));

TEST_P(MomentKernelTest, RandomNormalsEqualTheReference) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 0.2, 17);
  const ColourMap colours = random_colours(width, height, 18);
  expect_near_reference(map, nullptr, bake(map));
  expect_near_reference(map, &colours, bake(map, &colours));
}

// The bytes do not depend on the available memory or on the first level.
TEST_P(MomentKernelTest, BandsOfAnyHeightAreTheSameBytes) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 0.05, 23);
  const ColourMap colours = random_colours(width, height, 24);
  const MomentMipmap whole = bake(map, &colours);
  const auto level_count = static_cast<int>(whole.levels.size());
  for (const int first_level : {0, std::min(2, level_count - 1)}) {
    AverageInputs inputs;
    inputs.first_level = first_level;
    inputs.threads = 2;
    int bakes = 0;
    for (inputs.memory_bytes = 1024; inputs.memory_bytes < (1u << 22); inputs.memory_bytes *= 2) {
      std::optional<MomentMipmap> baked;
      try {
        baked = bake(map, &colours, inputs);
      } catch (const Error& error) {  // this memory is too small for a single row
        ASSERT_EQ(error.code(), ErrorCode::kUsage) << error.what();
        ASSERT_NE(std::string(error.what()).find("--memory"), std::string::npos) << error.what();
        continue;
      }
      ++bakes;
      for (int l = first_level; l < level_count; ++l) {
        const MomentLevel &a = whole.levels[static_cast<std::size_t>(l)],
                          &b = baked->levels[static_cast<std::size_t>(l)];
        ASSERT_EQ(a.slopes.size(), b.slopes.size());
        EXPECT_EQ(std::memcmp(a.slopes.data(), b.slopes.data(), a.slopes.size() * sizeof(SlopeMoments)), 0) << l;
        EXPECT_EQ(std::memcmp(a.normals.data(), b.normals.data(), a.normals.size() * sizeof(glm::vec3)), 0) << l;
        EXPECT_EQ(std::memcmp(a.colours.data(), b.colours.data(), a.colours.size() * sizeof(glm::vec3)), 0) << l;
      }
      for (int l = 0; l < first_level; ++l) EXPECT_TRUE(baked->levels[static_cast<std::size_t>(l)].slopes.empty());
    }
    EXPECT_GT(bakes, 3);
  }
}

// Every texel of the finest level counts once in each level. Hence all levels have the same mean if texels are weighted
// by the covered area.
TEST_P(MomentKernelTest, EveryLevelHasTheSameMean) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 0.3, 29);
  const MomentMipmap baked = bake(map);
  glm::dvec3 first(0.0);
  double first_square = 0.0;
  for (std::size_t l = 0; l < baked.levels.size(); ++l) {
    glm::dvec3 mean(0.0);
    double square = 0.0;
    // All texels of this level have equal areas.
    const auto count = static_cast<double>(baked.levels[l].normals.size());
    for (const glm::vec3& n : baked.levels[l].normals) mean += glm::dvec3(n) / count;
    for (const SlopeMoments& m : baked.levels[l].slopes) square += static_cast<double>(m.ss) / count;
    if (l == 0) {
      first = mean;
      first_square = square;
    }
    EXPECT_LT(glm::length(mean - first), 1e-6) << l;
    EXPECT_NEAR(square, first_square, 2e-6 * std::max(1.0, first_square)) << l;
  }
}

TEST(MomentClosedFormTest, AConstantMapHasNoVariance) {
  const glm::dvec3 n = glm::normalize(glm::dvec3(0.3, -0.5, 0.9));
  for (const auto& [width, height] : {Size{64, 64}, Size{50, 21}}) {
    const MomentMipmap baked = bake(make_map(width, height, [&](int, int) { return n; }));
    for (const MomentLevel& level : baked.levels)
      for (std::size_t i = 0; i < level.slopes.size(); ++i) {
        const SlopeMoments& m = level.slopes[i];
        EXPECT_NEAR(static_cast<double>(m.s), -n.x / n.z, 1e-6);
        EXPECT_NEAR(static_cast<double>(m.t), -n.y / n.z, 1e-6);
        // A hundredth of the smallest standard deviation of slopes that the documentation states for floats, squared.
        EXPECT_NEAR(static_cast<double>(m.ss - m.s * m.s), 0.0, 1e-6);
        EXPECT_NEAR(static_cast<double>(m.tt - m.t * m.t), 0.0, 1e-6);
        EXPECT_NEAR(static_cast<double>(glm::length(level.normals[i])), 1.0, 1e-6);
      }
  }
}

// In a V-groove of slopes +b and -b, E[b] = 0 and E[b^2] = b^2 exactly from level 1 on, because powers of two need no
// rounding.
TEST(MomentClosedFormTest, AGrooveHasTheSquareOfItsSlope) {
  const MomentMipmap baked =
      bake(make_map(64, 32, [](int x, int) { return glm::dvec3(x % 2 == 0 ? 0.6 : -0.6, 0.0, 0.8); }));
  const float slope = -0.6f / 0.8f;
  for (std::size_t l = 1; l < baked.levels.size(); ++l)
    for (std::size_t i = 0; i < baked.levels[l].slopes.size(); ++i) {
      const SlopeMoments& m = baked.levels[l].slopes[i];
      EXPECT_EQ(m.s, 0.0f);
      EXPECT_EQ(m.ss, slope * slope);
      EXPECT_EQ(m.tt, 0.0f);
      EXPECT_EQ(m.st, 0.0f);
      EXPECT_EQ(baked.levels[l].normals[i], glm::vec3(0.0f, 0.0f, 0.8f));
    }
}

// On a spherical cap around the pole, the slope at distance r from the pole is r / sqrt(1 - r^2). Over the disc of
// radius R, the mean of |b|^2 is -1 - ln(1 - R^2) / R^2, and the mean of n_z is 2 (1 - (1 - R^2)^1.5) / (3 R^2). The
// square around the disc is flat outside it. With 256 texels per side, the edge of the disc is resolved to about 1 %.
TEST(MomentClosedFormTest, AHemispheresCapHasItsIntegrals) {
  constexpr int kSize = 256;
  constexpr double kRadius = 0.9;
  const MomentMipmap baked = bake(make_map(kSize, kSize, [](int x, int y) {
    const double u = (2.0 * (x + 0.5) / kSize - 1.0) * kRadius, v = (1.0 - 2.0 * (y + 0.5) / kSize) * kRadius;
    const double r2 = u * u + v * v;
    return r2 < kRadius * kRadius ? glm::dvec3(u, v, std::sqrt(1.0 - r2)) : glm::dvec3(0.0, 0.0, 1.0);
  }));
  const double disc = M_PI / 4.0, r2 = kRadius * kRadius;
  const SlopeMoments& m = baked.levels.back().slopes[0];
  const double square = disc * (-1.0 - std::log(1.0 - r2) / r2);
  EXPECT_NEAR(static_cast<double>(m.ss), 0.5 * square, 0.01 * square);
  EXPECT_NEAR(static_cast<double>(m.tt), 0.5 * square, 0.01 * square);
  EXPECT_NEAR(static_cast<double>(m.s), 0.0, 1e-6);
  EXPECT_NEAR(static_cast<double>(m.st), 0.0, 1e-6);
  const double z = disc * 2.0 * (1.0 - std::pow(1.0 - r2, 1.5)) / (3.0 * r2) + (1.0 - disc);
  EXPECT_NEAR(static_cast<double>(baked.levels.back().normals[0].z), z, 1e-3);
}

// Slopes have no bound, but stored moments do: |b| is at most 20, and products are at most 400. Every clamped slope is
// counted.
TEST(MomentHardCaseTest, NormalsAtTheRimAreBoundedAndCounted) {
  AverageReport report;
  const NormalMap map = make_map(8, 4, [](int x, int y) {
    if (y > 0) return glm::dvec3(0.0, 0.0, 1.0);
    constexpr double kZ[] = {0.0, 1.0 / 512.0, 1e-30, 0.0499, 0.0501, 0.06, 0.5, 1.0};
    const double z = kZ[x], side = std::sqrt(1.0 - z * z);
    return glm::dvec3(x % 2 == 0 ? side : 0.0, x % 2 == 0 ? 0.0 : -side, z);
  });
  const MomentMipmap baked = bake_moments(test_device(), map, nullptr, {}, report, nullptr);
  EXPECT_EQ(report.slopes_limited, 4u);
  for (const MomentLevel& level : baked.levels)
    for (const SlopeMoments& m : level.slopes) {
      EXPECT_TRUE(std::isfinite(m.s) && std::isfinite(m.t) && std::isfinite(m.st));
      EXPECT_LE(std::hypot(m.s, m.t), 20.0f);
      EXPECT_LE(m.ss + m.tt, 400.0f * 1.000001f);
    }
  EXPECT_EQ(baked.levels[0].slopes[0].s, -20.0f);
  EXPECT_GT(baked.levels[0].slopes[1].t, 19.99f);  // -y is up, so the surface rises along +t
  expect_near_reference(map, nullptr, baked);
}

TEST(MomentHardCaseTest, CancellingIsHeard) {
  const NormalMap map = random_map(64, 64, 0.3, 31);
  AverageInputs inputs;
  inputs.memory_bytes = 40 * 1024;  // enough for a few rows per band
  int calls = 0;
  std::uint64_t done = 0, total = 0;
  Progress cancels([&](const ProgressEvent& event) {
    done = event.units_done;
    return ++calls < 4;
  });
  AverageReport report;
  EXPECT_THROW(bake_moments(test_device(), map, nullptr, inputs, report, &cancels), Cancelled);
  EXPECT_LT(done, 32u * 64u);
  Progress listens([&](const ProgressEvent& event) {
    total = event.units_done;
    return true;
  });
  bake_moments(test_device(), map, nullptr, inputs, report, &listens);
  EXPECT_EQ(total, 64u * 64u) << "a unit a texel";
}

TEST(MomentHardCaseTest, FirstLevelsThatTheMapHasNot) {
  AverageInputs inputs;
  inputs.first_level = 4;
  EXPECT_NO_THROW(bake(random_map(16, 8, 0.3, 1), nullptr, inputs));
  inputs.first_level = 5;
  EXPECT_THROW(bake(random_map(16, 8, 0.3, 1), nullptr, inputs), Error);
}

}  // namespace
}  // namespace multum
