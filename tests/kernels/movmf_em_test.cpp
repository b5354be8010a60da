// SPDX-License-Identifier: Apache-2.0
// Compares the EM kernels with the double reference on random maps. The results of the scalar and vector variants must
// be equal bit for bit.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include <glm/geometric.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "tests/fixtures/test_maps.h"
#include "tests/kernels/em_harness.h"

namespace multum::testing {
namespace {

constexpr Representation kGmm = Representation::kGmm;

// Makes three slightly rough facets, which EM should find.
NormalMap random_map(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  return make_map(width, height, [&](int, int) {
    const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24 * 2.0 - 1.0; };
    const int facet = static_cast<int>(random() % 3);
    const double x = uniform(), y = uniform(), z = uniform();
    const glm::dvec3 n(facet == 0 ? 0.6 : facet == 1 ? -0.5 : 0.0, facet == 2 ? 0.6 : 0.1, 0.8);
    return glm::normalize(glm::normalize(n) + 0.15 * glm::dvec3(x, y, z));
  });
}

std::vector<MultumVmfLobe> random_parent(const NormalMap& map, int level, int lobe_count, unsigned seed,
                                         Representation representation = Representation::kMovmf) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  const int texels = mip_level_size(map.width, level + 1) * mip_level_size(map.height, level + 1);
  std::vector<MultumVmfLobe> parent(static_cast<std::size_t>(lobe_count * texels));
  for (MultumVmfLobe& lobe : parent) {
    const glm::vec3 r =
        glm::normalize(glm::vec3(2 * uniform() - 1, 2 * uniform() - 1, 0.3f + uniform())) * (0.5f + 0.49f * uniform());
    lobe = {r.x, r.y, r.z, 1.0f / static_cast<float>(lobe_count)};
    if (representation == Representation::kGmm) lobe.mean_z = 0.002f + 0.2f * std::abs(r.z);  // sigma^2
  }
  return parent;
}

struct Case {
  int width, height, level, lobes;
  FitMethod method = FitMethod::kTexels;
  Representation representation = Representation::kMovmf;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.width << "x" << c.height << " level " << c.level << ", " << c.lobes << " lobes"
       << (c.method == FitMethod::kChunks   ? ", chunked"
           : c.method == FitMethod::kBinned ? ", binned"
                                            : "")
       << (c.representation == Representation::kGmm ? ", Gaussians" : "");
}

class MovmfEmTest : public ::testing::TestWithParam<Case> {};

// These are the reasons for the tolerances. One E-step in single precision has an error of about 1e-6 in each sum. In 4
// iterations on these maps, EM amplifies differences by a factor below 10. Hence 2e-5 would be enough, and the bound
// for (a r, a) is 1e-4. One lobe in 200 may compete evenly with another lobe, so its bound is 1e-2.
TEST_P(MovmfEmTest, EqualsReference) {
  const Case c = GetParam();
  const unsigned seed = 20061u + static_cast<unsigned>(c.width * 7 + c.level);
  SCOPED_TRACE(seed);
  const NormalMap map = random_map(c.width, c.height, seed);
  const auto parent = random_parent(map, c.level, c.lobes, seed + 1, c.representation);
  LevelFit how;
  how.representation = c.representation;
  how.level = c.level;
  how.iterations = 4;
  how.method = c.method;
  const auto expected = fit_with_reference(map, parent, c.lobes, how);
  for (bool scalar : {false, true}) {
    how.scalar = scalar;
    const auto found = fit_with_kernels(map, parent, c.lobes, how);
    ASSERT_EQ(found.size(), expected.size());
    std::size_t off = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const glm::dvec3 r(found[i].mean_x, found[i].mean_y, found[i].mean_z);
      const double a = static_cast<double>(found[i].amplitude);
      const double error =
          std::max(std::abs(a - expected[i].amplitude), glm::length(a * r - expected[i].amplitude * expected[i].r));
      EXPECT_LT(error, 1e-2) << "lobe slot " << i;
      if (!(error < 1e-4)) ++off;
    }
    EXPECT_LE(off, found.size() / 200 + 1) << (scalar ? "scalar" : "vector");
  }
}

TEST_P(MovmfEmTest, ScalarEqualsVectorBitForBit) {
  const Case c = GetParam();
  const NormalMap map = random_map(c.width, c.height, 77);
  const auto parent = random_parent(map, c.level, c.lobes, 78, c.representation);
  LevelFit how;
  how.representation = c.representation;
  how.level = c.level;
  how.method = c.method;
  const auto vector = fit_with_kernels(map, parent, c.lobes, how);
  how.scalar = true;
  const auto scalar = fit_with_kernels(map, parent, c.lobes, how);
  ASSERT_EQ(vector.size(), scalar.size());
  EXPECT_EQ(0, std::memcmp(vector.data(), scalar.data(), vector.size() * sizeof(MultumVmfLobe)));
}

INSTANTIATE_TEST_SUITE_P(Maps, MovmfEmTest,
                         ::testing::Values(Case{32, 32, 1, 4}, Case{32, 32, 2, 3}, Case{64, 32, 3, 1},
                                           Case{32, 32, 3, 8}, Case{64, 64, 5, 4, FitMethod::kChunks},
                                           Case{128, 128, 6, 4, FitMethod::kChunks}, Case{20, 12, 1, 4},
                                           Case{37, 21, 2, 3}, Case{21, 37, 3, 4, FitMethod::kChunks},
                                           Case{1, 37, 1, 4}, Case{64, 1, 3, 2},
                                           Case{50, 70, 2, 2, FitMethod::kChunks}));

// Repeats the test for planar Gaussians, whose lobes and references are (mean x, mean y, sigma^2).
INSTANTIATE_TEST_SUITE_P(
    Gaussians, MovmfEmTest,
    ::testing::Values(Case{32, 32, 1, 4, FitMethod::kTexels, kGmm}, Case{32, 32, 3, 8, FitMethod::kTexels, kGmm},
                      Case{37, 21, 2, 3, FitMethod::kTexels, kGmm}, Case{1, 37, 1, 4, FitMethod::kTexels, kGmm},
                      Case{64, 64, 5, 4, FitMethod::kChunks, kGmm}, Case{21, 37, 3, 4, FitMethod::kChunks, kGmm}));

// There are two ways of summing, and the size of a texel decides which one is used. Both ways must give the same
// result.
TEST(MovmfEmPathTest, ChunkedAgreesWithUnchunked) {
  const NormalMap map = random_map(64, 64, 5);
  const auto parent = random_parent(map, 4, 4, 6);
  LevelFit how;
  how.level = 4;
  const auto unchunked = fit_with_kernels(map, parent, 4, how);
  how.method = FitMethod::kChunks;
  const auto chunked = fit_with_kernels(map, parent, 4, how);
  for (std::size_t i = 0; i < chunked.size(); ++i) {
    EXPECT_NEAR(chunked[i].amplitude, unchunked[i].amplitude, 1e-4);
    EXPECT_NEAR(chunked[i].mean_z * chunked[i].amplitude, unchunked[i].mean_z * unchunked[i].amplitude, 1e-4);
  }
}

double difference(const MultumVmfLobe& lobe, const reference::Moments& expected) {
  const glm::dvec3 r(lobe.mean_x, lobe.mean_y, lobe.mean_z);
  const double a = static_cast<double>(lobe.amplitude);
  return std::max(std::abs(a - expected.amplitude), glm::length(a * r - expected.amplitude * expected.r));
}

// Returns the part of r whose sum over the lobes of a texel does not depend on the shares. For Gaussians this part
// includes E[x^2 + y^2].
glm::dvec3 kept_by_shares(const glm::dvec3& r, Representation representation) {
  return representation == kGmm ? glm::dvec3(r.x, r.y, 2.0 * r.z + r.x * r.x + r.y * r.y) : r;
}

LevelFit binned_fit(int level, Representation representation = Representation::kMovmf) {
  LevelFit how;
  how.representation = representation;
  how.level = level;
  how.method = FitMethod::kBinned;
  return how;
}

struct BinnedCase {
  int width, height, level, lobes;
  Representation representation = Representation::kMovmf;
};

// Makes facets with steep outliers, which must not stretch the axes.
NormalMap facets_with_outliers(int width, int height) {
  NormalMap map = random_map(width, height, 91);
  for (std::size_t i = 0; i < map.x.size(); i += 97) {
    map.x[i] = i % 2 == 0 ? 0.995f : -0.995f;
    map.y[i] = 0.0f;
    map.z[i] = std::sqrt(1.0f - 0.995f * 0.995f);
  }
  return map;
}

class BinnedTest : public ::testing::TestWithParam<BinnedCase> {
 protected:
  const int lobes_ = GetParam().lobes;
  const NormalMap map_ = facets_with_outliers(GetParam().width, GetParam().height);
  const std::vector<MultumVmfLobe> parent_ =
      random_parent(map_, GetParam().level, lobes_, 92, GetParam().representation);
  LevelFit how_ = binned_fit(GetParam().level, GetParam().representation);
};

// Binned texels lose only the place of a normal within its cell, so 4 iterations end close to the reference, which uses
// every normal. The width of a cell is 1/31 of the mean extent, and the width of a lobe is about a quarter. Binning
// blurs a lobe by about 1/100 of its spread, and changes the shares of two competing lobes by less than that. Each
// texel's mean normal is exact.
TEST_P(BinnedTest, EqualsReferenceClosely) {
  how_.iterations = 4;
  const auto expected = fit_with_reference(map_, parent_, lobes_, how_);
  const auto found = fit_with_kernels(map_, parent_, lobes_, how_);
  const std::size_t texels = found.size() / static_cast<std::size_t>(lobes_);
  double sum = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LT(difference(found[i], expected[i]), 3e-2) << "lobe slot " << i;
    sum += difference(found[i], expected[i]);
  }
  EXPECT_LT(sum / static_cast<double>(found.size()), 3e-3);
  for (std::size_t t = 0; t < texels; ++t) {
    glm::dvec4 mean(0.0), mean_expected(0.0);
    for (std::size_t i = t; i < found.size(); i += texels) {
      const MultumVmfLobe& lobe = found[i];
      const glm::dvec3 r(lobe.mean_x, lobe.mean_y, lobe.mean_z);
      mean += static_cast<double>(lobe.amplitude) * glm::dvec4(kept_by_shares(r, how_.representation), 1.0);
      mean_expected += expected[i].amplitude * glm::dvec4(kept_by_shares(expected[i].r, how_.representation), 1.0);
    }
    EXPECT_LT(glm::length(mean - mean_expected), 1e-5) << "texel " << t;
  }
}

TEST_P(BinnedTest, ScalarEqualsVectorBitForBit) {
  const auto vector = fit_with_kernels(map_, parent_, lobes_, how_);
  how_.scalar = true;
  const auto scalar = fit_with_kernels(map_, parent_, lobes_, how_);
  EXPECT_EQ(0, std::memcmp(vector.data(), scalar.data(), vector.size() * sizeof(MultumVmfLobe)));
}

// The map is read in bands of rows. The sums are integers, so the height of the bands does not change the result.
TEST_P(BinnedTest, BandsOfAnyHeightGiveTheSameBytes) {
  const int all_rows = how_.bin_rows;
  for (const bool scalar : {false, true}) {
    how_.scalar = scalar;
    how_.bin_rows = all_rows;
    const auto whole = fit_with_kernels(map_, parent_, lobes_, how_);
    for (const int rows : {1, 7, 64}) {
      how_.bin_rows = rows;
      const auto banded = fit_with_kernels(map_, parent_, lobes_, how_);
      EXPECT_EQ(0, std::memcmp(whole.data(), banded.data(), whole.size() * sizeof(MultumVmfLobe)))
          << rows << " rows" << (scalar ? ", scalar" : "");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, BinnedTest,
                         ::testing::Values(BinnedCase{128, 64, 6, 4}, BinnedCase{128, 128, 6, 8},
                                           BinnedCase{129, 150, 6, 3}, BinnedCase{64, 64, 4, 2},
                                           BinnedCase{3000, 1, 11, 2}, BinnedCase{128, 64, 6, 4, kGmm},
                                           BinnedCase{129, 150, 6, 3, kGmm}),
                         [](const auto& c) {
                           return std::to_string(c.param.width) + "x" + std::to_string(c.param.height) + "_level" +
                                  std::to_string(c.param.level) + "_lobes" + std::to_string(c.param.lobes) +
                                  (c.param.representation == kGmm ? "_gaussians" : "");
                         });

// A map of one repeated normal has no extent.
TEST(CondensedFlatTest, OneNormalStaysWhole) {
  const NormalMap map = make_map(64, 64, [](int, int) { return glm::normalize(glm::dvec3(0.3, -0.2, 0.9)); });
  const auto found = fit_with_kernels(map, random_parent(map, 5, 2, 8), 2, binned_fit(5));
  for (std::size_t t = 0; t < 4; ++t) {
    const double a = static_cast<double>(found[t].amplitude), b = static_cast<double>(found[t + 4].amplitude);
    EXPECT_NEAR(a + b, 1.0, 1e-6);
    EXPECT_NEAR(a * static_cast<double>(found[t].mean_x) + b * static_cast<double>(found[t + 4].mean_x), map.x[0],
                1e-6);
  }
}

// The iterations of a texel stop once it has converged, whatever the other texels of its group do. Hence the variants
// agree, and fewer iterations change the result only a little.
TEST(SettledTest, ScalarEqualsVectorAndTheLongRunIsNear) {
  const NormalMap map = random_map(128, 128, 15);
  const auto parent = random_parent(map, 3, 4, 16);
  LevelFit how;
  how.level = 3;
  how.iterations = 60;
  const auto all = fit_with_kernels(map, parent, 4, how);
  how.convergence_tolerance = 0.01f;
  const auto vector = fit_with_kernels(map, parent, 4, how);
  how.scalar = true;
  const auto scalar = fit_with_kernels(map, parent, 4, how);
  EXPECT_EQ(0, std::memcmp(vector.data(), scalar.data(), vector.size() * sizeof(MultumVmfLobe)));
  EXPECT_NE(0, std::memcmp(vector.data(), all.data(), vector.size() * sizeof(MultumVmfLobe))) << "nothing stopped";
  double sum = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i)
    sum += std::abs(static_cast<double>(vector[i].amplitude) - static_cast<double>(all[i].amplitude));
  EXPECT_LT(sum / static_cast<double>(all.size()), 0.02);
}

}  // namespace
}  // namespace multum::testing
