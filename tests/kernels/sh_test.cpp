// SPDX-License-Identifier: Apache-2.0
// Runs kernels/sh_project.cl with mip_box.cl, and compares the result with averages of the basis functions in double
// precision. The sizes of levels nest or do not nest, and bands have any height. host/lab/selftest/sh_cases.cpp has
// numerical cases of both kernels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include <glm/geometric.hpp>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/averages/sh_bake.h"
#include "host/formats/asset/averages/spherical_harmonics.h"
#include "host/foundation/base/error.h"
#include "host/lab/reference/coverage.h"
#include "host/lab/reference/spherical_harmonics.h"
#include "tests/fixtures/test_maps.h"
#include "tests/kernels/em_harness.h"

namespace multum {
namespace {

using testing::make_map;
using testing::random_colours;
using testing::random_map;
using testing::test_device;

ShMipmap bake(int order, const NormalMap& map, const ColourMap* albedo = nullptr, const AverageInputs& inputs = {}) {
  AverageReport report;
  return bake_sh(test_device(), order, map, albedo, inputs, report, nullptr);
}

glm::dvec3 normal(const NormalMap& map, std::size_t i) {
  return {static_cast<double>(map.x[i]), static_cast<double>(map.y[i]), static_cast<double>(map.z[i])};
}

// At order 20, the error of the basis functions is within 1e-5 of their bound (selftest). Averaging adds an error of
// about 2^-24 per step.
constexpr double kShTolerance = 1e-5;

void expect_near_reference(const NormalMap& map, const ColourMap* albedo, const ShMipmap& baked) {
  std::vector<std::vector<double>> basis;
  for (std::size_t i = 0; i < map.x.size(); ++i) basis.push_back(reference::sh_basis_to(baked.order, normal(map, i)));
  ASSERT_EQ(static_cast<int>(baked.levels.size()), mip_level_count(map.width, map.height));
  for (const ShLevel& level : baked.levels) {
    ASSERT_EQ(static_cast<int>(level.parts.size()), sh_part_count(baked.order));
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x) {
        std::vector<double> sums(basis[0].size(), 0.0);
        glm::dvec3 colour(0.0);
        double total = 0.0;
        reference::for_each_covered(map.width, map.height, level.width, level.height, x, y,
                                    [&](std::size_t i, double weight) {
                                      for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += weight * basis[i][k];
                                      if (albedo != nullptr)
                                        colour += weight * glm::dvec3(albedo->r[i], albedo->g[i], albedo->b[i]);
                                      total += weight;
                                    });
        const auto at =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(level.width) + static_cast<std::size_t>(x);
        for (std::size_t k = 0; k < sums.size(); ++k)
          ASSERT_NEAR(static_cast<double>(level.value(static_cast<int>(k), at)), sums[k] / total,
                      kShTolerance * std::sqrt((2.0 * baked.order + 1.0) / (4.0 * M_PI)))
              << level.width << " wide, texel (" << x << ", " << y << "), coefficient " << k;
        for (int c = 0; albedo != nullptr && c < 3; ++c)
          ASSERT_NEAR(static_cast<double>(level.colours[at][c]), colour[c] / total, 1.5e-6);
      }
  }
}

bool is_same(const ShLevel& a, const ShLevel& b) {
  if (a.parts.size() != b.parts.size() || a.colours != b.colours || a.weights != b.weights) return false;
  for (std::size_t p = 0; p < a.parts.size(); ++p)
    if (a.parts[p].size() != b.parts[p].size() ||
        std::memcmp(a.parts[p].data(), b.parts[p].data(), a.parts[p].size() * sizeof(glm::vec4)) != 0)
      return false;
  return true;
}

struct Shape {
  int order, width, height;
};

void PrintTo(const Shape& s, std::ostream* out) { *out << "order " << s.order << ", " << s.width << " x " << s.height; }

class ShKernelTest : public ::testing::TestWithParam<Shape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, ShKernelTest,
                         ::testing::Values(Shape{20, 1, 1}, Shape{8, 2, 2}, Shape{3, 1, 17}, Shape{4, 33, 1},
                                           Shape{1, 16, 32}, Shape{2, 11, 7}, Shape{5, 3, 40}, Shape{8, 19, 33}));

TEST_P(ShKernelTest, RandomNormalsEqualTheReference) {
  const auto [order, width, height] = GetParam();
  const NormalMap map = random_map(width, height, 0.0, 17);
  const ColourMap colours = random_colours(width, height, 18);
  expect_near_reference(map, nullptr, bake(order, map));
  expect_near_reference(map, &colours, bake(order, map, &colours));
}

// The bytes do not depend on the available memory or on the first level.
TEST_P(ShKernelTest, BandsOfAnyHeightAreTheSameBytes) {
  const auto [order, width, height] = GetParam();
  NormalMap map = random_map(width, height, 0.0, 23);
  for (std::size_t i = 0; i < map.x.size(); ++i)
    for (std::vector<float>* plane : {&map.x, &map.y, &map.z}) (*plane)[i] *= 1.0f - 0.1f * static_cast<float>(i % 6);
  const ColourMap colours = random_colours(width, height, 24);
  WeightMap weights;
  weights.count = 2;
  const ColourMap weighted = random_colours(width, height, 25);  // this object owns the memory of the planes
  weights.rgb_planes.push_back(planes_of(weighted));
  map.is_shortened = true;
  AverageInputs inputs;
  inputs.features = FeaturePlanes::of(nullptr, &weights);
  const ShMipmap whole = bake(order, map, &colours, inputs);
  const auto level_count = static_cast<int>(whole.levels.size());
  for (const int first_level : {0, std::min(2, level_count - 1)}) {
    inputs.first_level = first_level;
    inputs.threads = 2;
    int bakes = 0;
    for (inputs.memory_bytes = 1024; inputs.memory_bytes < (1u << 22); inputs.memory_bytes *= 4) {
      std::optional<ShMipmap> baked;
      try {
        baked = bake(order, map, &colours, inputs);
      } catch (const Error& error) {  // this memory is too small for a single row
        ASSERT_EQ(error.code(), ErrorCode::kUsage) << error.what();
        continue;
      }
      ++bakes;
      for (int l = 0; l < level_count; ++l) {
        const auto i = static_cast<std::size_t>(l);
        if (l < first_level) EXPECT_TRUE(baked->levels[i].parts.empty());
        else EXPECT_TRUE(is_same(whole.levels[i], baked->levels[i])) << l;
      }
    }
    EXPECT_GT(bakes, 1);
  }
}

// On a checkerboard of two opposite tilts, terms that are odd in x cancel to the last bit, and even terms do not
// change.
TEST(ShClosedFormTest, OppositeTiltsCancelWhatIsOdd) {
  constexpr int kOrder = 8;
  const ShMipmap baked =
      bake(kOrder, make_map(64, 32, [](int x, int) { return glm::dvec3(x % 2 == 0 ? 0.6 : -0.6, 0.0, 0.8); }));
  for (std::size_t l = 1; l < baked.levels.size(); ++l)
    for (std::size_t i = 0; i < baked.levels[l].parts[0].size(); ++i)
      for (int band = 1; band <= kOrder; ++band)
        for (int m = -band; m <= band; ++m) {
          const float value = baked.levels[l].value(sh_coefficient(band, m), i);
          if (m < 0 || m % 2 == 1) EXPECT_EQ(value, 0.0f) << band << ", " << m;
          else EXPECT_EQ(value, baked.levels[0].value(sh_coefficient(band, m), 0)) << band << ", " << m;
        }
}

// Compares the recurrences of the zonal coefficients with quadrature.
TEST(ZonalTest, RecurrencesEqualQuadrature) {
  for (const double s : {1.0, 12.0, 20.0, 100.0, 500.0}) {
    const ZonalCoefficients found = zonal_blinn_phong(kShOrderMax, s);
    const std::vector<double> exact = reference::zonal_by_quadrature(
        kShOrderMax, [s](double t) { return t > 0.0 ? (s + 1.0) / (2.0 * M_PI) * std::pow(t, s) : 0.0; });
    for (std::size_t l = 0; l < found.size(); ++l) EXPECT_NEAR(found[l], exact[l], 2e-6) << s << ", " << l;
  }
  const ZonalCoefficients lambert = zonal_lambert(kShOrderMax);
  const std::vector<double> exact =
      reference::zonal_by_quadrature(kShOrderMax, [](double t) { return std::max(t, 0.0); });
  for (std::size_t l = 0; l < lambert.size(); ++l) EXPECT_NEAR(lambert[l], exact[l], 1e-6) << l;
  EXPECT_EQ(zonal_lambert(0).size(), 1u);
}

// According to section 5 of Han et al., 9 coefficients are enough for Lambert, and bands up to l = 2 sqrt(s) are enough
// for Blinn-Phong.
TEST(ShAccuracyTest, AnOrderThatSufficesIsNear) {
  const NormalMap map = random_map(64, 64, 0.0, 41);
  const auto worst = [&](int order, const AccuracyBrdf& brdf, double exponent) {
    AccuracySettings settings;
    settings.exponents = {exponent};
    settings.samples_per_level = 64;
    double found = 0.0;
    for (const AccuracyRow& row : measure_accuracy(test_device(), bake(order, map), map, nullptr, settings, nullptr))
      if (row.level >= 2 && row.brdf == brdf) found = std::max(found, row.error);
    return found;
  };
  EXPECT_LT(worst(2, AccuracyBrdf::lambert(), 12.0), 0.04);
  EXPECT_LT(worst(8, AccuracyBrdf::blinn_phong(12.0), 12.0), 0.03);
  EXPECT_LT(worst(20, AccuracyBrdf::blinn_phong(100.0), 100.0), 0.15);
  EXPECT_GT(worst(4, AccuracyBrdf::blinn_phong(100.0), 100.0), 0.10) << "4 is far below 2 sqrt(100)";
}

TEST(ShHardCaseTest, CancellingIsHeardAndOrdersAreChecked) {
  const NormalMap map = random_map(64, 64, 0.0, 31);
  AverageInputs inputs;
  inputs.memory_bytes = 96 * 1024;  // enough for a few rows per band
  int calls = 0;
  std::uint64_t done = 0;
  Progress cancels([&](const ProgressEvent& event) {
    done = event.units_done;
    return ++calls < 4;
  });
  AverageReport report;
  EXPECT_THROW(bake_sh(test_device(), 4, map, nullptr, inputs, report, &cancels), Cancelled);
  EXPECT_LT(done, 32u * 64u);
  for (const int order : {-1, 0, 21}) EXPECT_THROW(bake(order, map), Error) << order;
  inputs.first_level = 7;
  EXPECT_THROW(bake(4, map, nullptr, inputs), Error);
}

}  // namespace
}  // namespace multum
