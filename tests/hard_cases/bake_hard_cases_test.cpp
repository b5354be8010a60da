// SPDX-License-Identifier: Apache-2.0
// Bakes the hard cases of fitting. The results must be finite, conserve the averages, and be correct where a closed
// form gives the answer.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include <glm/geometric.hpp>

#include "host/bakes/movmf/movmf_bake.h"
#include "host/formats/opencl/launch_shape.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::make_map;

struct Baked {
  MovmfMipmap mipmap;
  FitReport report;
};

enum class Variant { kVector, kScalar, kReference };

Baked bake(const NormalMap& map, int lobes, Variant variant) {
  static Device device = Device::open("");
  MovmfSettings settings;
  settings.lobe_count = lobes;
  device.set_shape(variant == Variant::kScalar ? LaunchShape::of_accelerator(device.info())
                                               : LaunchShape::of(device.info()));
  if (variant == Variant::kReference) make_reference(settings);
  Baked baked;
  baked.mipmap = bake_movmf(device, map, nullptr, settings, baked.report, nullptr);
  EXPECT_EQ(baked.report.nonfinite, 0u);
  for (const MovmfLevel& level : baked.mipmap.levels)
    for (std::size_t i = 0; i < level.lobes[0].size(); ++i) {
      float sum = 0.0f;
      for (const auto& lobe : level.lobes) {
        sum += lobe[i].w;
        EXPECT_GE(lobe[i].w, 0.0f);
        EXPECT_LE(glm::length(glm::vec3(lobe[i])), lobe[i].w * 1.000001f + 1e-9f);
      }
      EXPECT_NEAR(sum, 1.0f, 1e-5f);
    }
  return baked;
}

// Returns the weighted mean of 1 - |r| over the lobes that point in one direction.
double spread_of(const MovmfLevel& level, std::size_t texel) {
  double spread = 0.0;
  for (const auto& lobe : level.lobes) {
    const glm::dvec4 v(lobe[texel]);
    if (v.w > 1e-6) spread += v.w - glm::length(glm::dvec3(v));
  }
  return spread;
}

glm::dvec3 tilted(double degrees, double azimuth = 0.3) {
  const double t = degrees * M_PI / 180.0;
  return {std::sin(t) * std::cos(azimuth), std::sin(t) * std::sin(azimuth), std::cos(t)};
}

class HardCaseTest : public ::testing::TestWithParam<Variant> {};  // tests both variants of the kernels
INSTANTIATE_TEST_SUITE_P(Variants, HardCaseTest,
                         ::testing::Values(Variant::kVector, Variant::kScalar, Variant::kReference),
                         [](const ::testing::TestParamInfo<Variant>& variant) {
                           return variant.param == Variant::kScalar      ? "Scalar"
                                  : variant.param == Variant::kReference ? "Reference"
                                                                         : "Vector";
                         });

// Tests kappa -> infinity, more lobes J than distinct normals, and identical starting lobes.
TEST_P(HardCaseTest, AllNormalsEqual) {
  for (double degrees : {0.0, 30.0, 60.0, 89.0}) {
    const glm::dvec3 n = glm::dvec3(glm::vec3(tilted(degrees)));
    const Baked baked = bake(make_map(64, 64, [&](int, int) { return n; }), 8, GetParam());
    for (const MovmfLevel& level : baked.mipmap.levels)
      for (std::size_t i = 0; i < level.lobes[0].size(); ++i) {
        EXPECT_LT(spread_of(level, i), 1e-6) << degrees << " degrees, level of width " << level.width;
        for (const auto& lobe : level.lobes)
          // When a thousand equal numbers are added, all additions may round in the same direction. The relative error
          // of the sum is then up to 1024 * 2^-25 = 3.1e-5, which is one storage step. The measured error is 1.1e-5.
          if (lobe[i].w > 1e-3f) {
            EXPECT_LT(glm::length(glm::dvec3(lobe[i]) / glm::length(glm::dvec3(lobe[i])) - n), 3.1e-5);
          }
      }
  }
}

// Two lobes must find two tilts with equal shares, whatever the angle between the tilts is.
TEST_P(HardCaseTest, TwoOppositeTilts) {
  for (double degrees : {10.0, 45.0, 80.0, 89.9}) {
    const glm::dvec3 a = tilted(degrees, 0.0), b = tilted(degrees, M_PI);
    const Baked baked = bake(make_map(32, 32, [&](int x, int y) { return ((x + y) & 1) != 0 ? a : b; }), 2, GetParam());
    for (std::size_t l = 1; l < baked.mipmap.levels.size(); ++l)
      for (std::size_t i = 0; i < baked.mipmap.levels[l].lobes[0].size(); ++i) {
        EXPECT_LT(spread_of(baked.mipmap.levels[l], i), 2e-6) << degrees << " degrees, level " << l;
        EXPECT_NEAR(baked.mipmap.levels[l].lobes[0][i].w, 0.5f, 1e-4f);
      }
  }
}

// A single lobe for two opposite normals on the equator has no direction, so r -> 0 and kappa -> 0.
TEST_P(HardCaseTest, OppositeNormalsOnTheEquatorWithOneLobe) {
  const Baked baked =
      bake(make_map(16, 16, [](int x, int) { return glm::dvec3((x & 1) != 0 ? 1.0 : -1.0, 0.0, 0.0); }), 1, GetParam());
  EXPECT_GT(baked.report.undirected_lobes, 0u);
  for (std::size_t l = 1; l < baked.mipmap.levels.size(); ++l)
    for (const glm::vec4& lobe : baked.mipmap.levels[l].lobes[0]) {
      EXPECT_LT(glm::length(glm::vec3(lobe)), 1e-5f);
      EXPECT_NEAR(lobe.w, 1.0f, 1e-6f);
    }
}

// Normals below the horizon reach the kernels only if a caller skips the repair by the reader. Even then, the result
// must be finite.
TEST_P(HardCaseTest, NormalsOverTheWholeSphere) {
  const Baked baked =
      bake(make_map(64, 64,
                    [](int x, int y) {
                      const double z = 1.0 - 2.0 * (y * 64 + x + 0.5) / 4096.0, phi = (y * 64 + x) * 2.399963;
                      return glm::dvec3(std::sqrt(1 - z * z) * std::cos(phi), std::sqrt(1 - z * z) * std::sin(phi), z);
                    }),
           4, GetParam());
  const glm::vec4 top = baked.mipmap.levels.back().lobes[0][0] + baked.mipmap.levels.back().lobes[1][0] +
                        baked.mipmap.levels.back().lobes[2][0] + baked.mipmap.levels.back().lobes[3][0];
  EXPECT_LT(glm::length(glm::vec3(top)), 1e-3f);
}

// Returns the sum of the amplitudes of the lobes that point within one degree of n.
double share_towards(const MovmfLevel& level, std::size_t texel, const glm::dvec3& n) {
  double share = 0.0;
  for (const auto& lobe : level.lobes) {
    const glm::dvec3 r(lobe[texel]);
    if (glm::dot(r, n) > std::cos(M_PI / 180.0) * glm::length(r)) share += static_cast<double>(lobe[texel].w);
  }
  return share;
}

glm::dvec3 mean_of(const MovmfLevel& level, std::size_t texel) {
  glm::dvec3 sum(0.0);
  for (const auto& lobe : level.lobes) sum += glm::dvec3(lobe[texel]);
  return sum;
}

// The map has only N = 1, 2 or 3 different normals. With N lobes, each lobe finds one normal. A single lobe has their
// mean. Sums of three floats and the last step of EM have a rounding error of 1e-6. If a lobe had two of these normals,
// its spread would be at least 0.01.
TEST_P(HardCaseTest, MapsOfOneTwoAndThreeTexels) {
  const auto normal = [](int x) { return tilted(20.0 * x, 1.0 * x); };
  for (int width : {1, 2, 3})
    for (int lobes : {1, 4, 8}) {
      SCOPED_TRACE(std::to_string(width) + " texels, " + std::to_string(lobes) + " lobes");
      const Baked baked = bake(make_map(width, 1, [&](int x, int) { return normal(x); }), lobes, GetParam());
      EXPECT_EQ(static_cast<int>(baked.mipmap.levels.size()), mip_level_count(width, 1));
      const MovmfLevel& top = baked.mipmap.levels.back();
      glm::dvec3 mean(0.0);
      for (int x = 0; x < width; ++x) mean += normal(x) / static_cast<double>(width);
      EXPECT_LT(glm::length(mean_of(top, 0) - mean), 2e-6);
      EXPECT_NEAR(spread_of(top, 0), lobes >= width ? 0.0 : 1.0 - glm::length(mean), 1e-5);
      for (int x = 0; lobes >= width && x < width; ++x)
        EXPECT_NEAR(share_towards(top, 0, normal(x)), 1.0 / width, 1e-4) << x;
    }
}

// A tiny spread must not be lost to rounding. Normals are within 0.4 degrees of their mean, and |r| = 1 - 1.2e-5.
TEST_P(HardCaseTest, NearlyEqualNormalsKeepTheirSpread) {
  const NormalMap map = make_map(64, 64, [](int x, int y) { return tilted(40.0 + 0.2 * ((x * 7 + y * 3) % 5), 0.2); });
  const Baked baked = bake(map, 1, GetParam());
  const MovmfLevel& top = baked.mipmap.levels.back();
  glm::dvec3 mean(0.0);
  for (std::size_t i = 0; i < map.x.size(); ++i)
    mean += glm::normalize(glm::dvec3(map.x[i], map.y[i], map.z[i])) / 4096.0;
  const double exact = 1.0 - glm::length(mean);
  // The kernels store 1 - |r| in addition to r. The result contains only a r in single precision, which changes this
  // spread of 1.2e-5 by at most 3e-7.
  EXPECT_NEAR(spread_of(top, 0) / exact, 1.0, 0.05) << "exact spread " << exact;
}

// Tests very small amplitudes: one normal in 4096 differs from the others. On every level, this normal keeps its own
// lobe. The share of this lobe has an error of at most one per cent, although sums of floats have errors of 1e-6. The
// mean includes this normal; without it, the coarsest mean would have an error of 2.6e-4.
TEST_P(HardCaseTest, ALobeOfOneNormalInThousands) {
  const auto normal = [](int x, int y) { return x == 5 && y == 7 ? tilted(70) : tilted(5, 0.01 * x); };
  const Baked baked = bake(make_map(64, 64, normal), 4, GetParam());
  EXPECT_GT(baked.report.lobe_count_total, 0u);
  for (int l = 1; l < static_cast<int>(baked.mipmap.levels.size()); ++l) {
    const MovmfLevel& level = baked.mipmap.levels[static_cast<std::size_t>(l)];
    const int side = 1 << l;
    const std::size_t texel = static_cast<std::size_t>((7 / side) * level.width + 5 / side);
    const double share = 1.0 / (side * side);
    glm::dvec3 mean(0.0);
    for (int y = (7 / side) * side; y < (7 / side + 1) * side; ++y)
      for (int x = (5 / side) * side; x < (5 / side + 1) * side; ++x) mean += share * normal(x, y);
    SCOPED_TRACE("level " + std::to_string(l));
    EXPECT_NEAR(share_towards(level, texel, tilted(70)) / share, 1.0, 0.01);
    EXPECT_LT(glm::length(mean_of(level, texel) - mean), 2e-6);
  }
}

// Samples that are shorter than 1 (mean vectors of rough texels) keep their spread. If |r| is 0.9 everywhere, it stays
// 0.9.
TEST_P(HardCaseTest, SamplesShorterThanOne) {
  const Baked baked = bake(make_map(32, 32, [](int, int) { return 0.9 * tilted(30); }), 3, GetParam());
  const MovmfLevel& top = baked.mipmap.levels.back();
  EXPECT_NEAR(spread_of(top, 0), 0.1, 1e-4);
}

// Tests strips of 1 x N and N x 1 texels, where N is any number down to 1, with powers of two and other sizes.
TEST_P(HardCaseTest, Strips) {
  for (int length : {2, 3, 37, 64, 1000, 2048})
    for (bool upright : {false, true}) {
      const Baked baked = bake(make_map(upright ? 1 : length, upright ? length : 1,
                                        [](int x, int y) { return tilted(((x + y) % 7) * 9.0, (x + y) * 0.1); }),
                               4, GetParam());
      EXPECT_EQ(baked.mipmap.levels.back().lobes[0].size(), 1u);
    }
}

}  // namespace
}  // namespace multum
