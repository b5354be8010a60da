// SPDX-License-Identifier: Apache-2.0
// Tests the initial lobes of the coarsest level: the candidates, and the proxy map on which the candidates are tried.
#include "host/bakes/movmf/movmf_start.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <set>

#include "host/foundation/base/mean_cosine.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::make_map;

const glm::dvec3 kFacets[4] = {{0.6, 0.0, 0.8}, {-0.6, 0.0, 0.8}, {0.0, 0.6, 0.8}, {0.0, -0.6, 0.8}};

// Makes a knurled plate, which has four facets in a pattern of `period` texels.
NormalMap knurled_plate(int width, int height, int period) {
  return make_map(width, height, [&](int x, int y) {
    const int u = x % period - period / 2, v = y % period - period / 2;
    return kFacets[std::abs(u) > std::abs(v) ? (u > 0 ? 0 : 1) : (v > 0 ? 2 : 3)];
  });
}

TEST(MovmfStartTest, ACandidateHasEveryFacetOfAPatternInStepWithPowersOfTwo) {
  for (int period : {4, 8, 16, 32}) {
    SCOPED_TRACE(period);
    const NormalMap map = knurled_plate(256, 256, period);
    const auto candidates = start_candidates(planes_of(map), {4, 500.0f, 1, 2});
    ASSERT_FALSE(candidates.empty());
    double sum = 0.0;
    std::set<int> found;
    for (const MultumVmfLobe& lobe : candidates.front()) {
      sum += static_cast<double>(lobe.amplitude);
      const glm::dvec3 r(lobe.mean_x, lobe.mean_y, lobe.mean_z);
      for (int f = 0; f < 4; ++f)
        if (glm::dot(glm::normalize(r), kFacets[f]) > 0.9999 && glm::length(r) > 0.999) found.insert(f);
    }
    EXPECT_EQ(found.size(), 4u);
    EXPECT_NEAR(sum, 1.0, 1e-5);
  }
}

TEST(MovmfStartTest, CandidatesDifferAndAreFewAndFiniteAndTheSameForAnyThreads) {
  const NormalMap map = knurled_plate(100, 37, 9);
  for (int lobes = 1; lobes <= 8; ++lobes) {
    SCOPED_TRACE(lobes);
    const auto one = start_candidates(planes_of(map), {lobes, 500.0f, 1, 1}),
               three = start_candidates(planes_of(map), {lobes, 500.0f, 1, 3});
    ASSERT_GE(one.size(), 1u);
    ASSERT_LE(one.size(), 24u);
    ASSERT_EQ(one.size(), three.size());
    for (std::size_t c = 0; c < one.size(); ++c) {
      ASSERT_EQ(one[c].size(), static_cast<std::size_t>(lobes));
      for (std::size_t j = 0; j < one[c].size(); ++j) {
        EXPECT_TRUE(std::isfinite(one[c][j].mean_x) && std::isfinite(one[c][j].amplitude));
        EXPECT_EQ(one[c][j].mean_x, three[c][j].mean_x);
        EXPECT_EQ(one[c][j].mean_z, three[c][j].mean_z);
        EXPECT_EQ(one[c][j].amplitude, three[c][j].amplitude);
      }
    }
  }
}

// Returns the relative L1 error of the highlights of the best candidate at s = 100, compared with the highlights of the
// map's normals.
double highlight_error(const NormalMap& map, const std::vector<MultumVmfLobe>& lobes) {
  constexpr double kSharpness = 100.0;
  const auto density = [](double kappa, double cosine) {
    return kappa / (1.0 - std::exp(-2.0 * kappa)) * std::exp(kappa * (cosine - 1.0));
  };
  const auto count = static_cast<double>(map.x.size());
  double difference = 0.0, total = 0.0;
  for (const glm::dvec3& h : spread_half_vectors(256)) {
    double exact = 0.0, model = 0.0;
    for (std::size_t i = 0; i < map.x.size(); ++i)
      exact += density(kSharpness, glm::dot(h, glm::dvec3(glm::vec3(map.x[i], map.y[i], map.z[i])))) / count;
    for (const MultumVmfLobe& lobe : lobes) {
      const glm::dvec3 r(lobe.mean_x, lobe.mean_y, lobe.mean_z);
      const double kappa = kappa_of_mean_cosine(glm::length(r) * (1.0 - 1.0 / kSharpness), 1e6);
      model += static_cast<double>(lobe.amplitude) * density(kappa, glm::dot(h, glm::normalize(r)));
    }
    difference += std::abs(model - exact);
    total += exact;
  }
  return difference / total;
}

// Makes normals in `count` clusters. Only a few clusters are broad or have a large share.
NormalMap clustered_map(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<glm::dvec3> centres;
  std::vector<double> widths, ends;
  double end = 0.0;
  for (int i = 0; i < count; ++i) {
    const double turn = 2.0 * M_PI * testing::uniform24(random), radius = 0.7 * testing::uniform24(random);
    centres.emplace_back(radius * std::cos(turn), radius * std::sin(turn), 1.0);
    widths.push_back(0.2 * std::pow(testing::uniform24(random), 5.0));
    ends.push_back(end += std::pow(testing::uniform24(random), 8.0));
  }
  std::normal_distribution<double> normal;
  return make_map(48, 48, [&](int, int) {
    const double place = end * testing::uniform24(random);
    const auto i = static_cast<std::size_t>(std::lower_bound(ends.begin(), ends.end(), place) - ends.begin());
    return glm::normalize(centres[i] + widths[i] * glm::dvec3(normal(random), normal(random), 0.0));
  });
}

// If clusters are sharp and broad and have very unequal shares, few random trials with 6 lobes find the best optimum.
// Trials that start with 4 lobes and then add lobes find it.
TEST(MovmfStartTest, StartsThatGrowFromFewerLobesAreNearer) {
  for (const unsigned seed : {16u, 110u, 111u, 129u}) {
    const NormalMap map = clustered_map(20, seed);
    StartSearch search{6, 500.0f, 1, 2};
    const double grown = highlight_error(map, start_candidates(planes_of(map), search).front());
    search.grows_starts = false;
    const double at_random = highlight_error(map, start_candidates(planes_of(map), search).front());
    EXPECT_LT(grown, 0.85 * at_random) << "seed " << seed;
    search.lobe_count = 4;
    EXPECT_LT(grown, highlight_error(map, start_candidates(planes_of(map), search).front())) << "4 lobes, " << seed;
  }
}

TEST(MovmfStartTest, ALikenessTakesEachNormalFromWhereItLies) {
  struct Case {
    int width, height, proxy_width, proxy_height;
  };
  for (const Case& test : {Case{1024, 512, 64, 64}, Case{403, 50, 64, 50}, Case{1, 300, 1, 64}, Case{1, 1, 1, 1}}) {
    SCOPED_TRACE(test.width);
    // Each normal encodes its own position in the map.
    const NormalMap map = make_map(test.width, test.height, [](int x, int y) { return glm::dvec3(x, y, 0.0); });
    const NormalMap proxy = sample_proxy_map(planes_of(map), 64, 1);
    ASSERT_EQ(proxy.width, test.proxy_width);
    ASSERT_EQ(proxy.height, test.proxy_height);
    const double cell_x = static_cast<double>(test.width) / proxy.width;
    const double cell_y = static_cast<double>(test.height) / proxy.height;
    for (int y = 0; y < proxy.height; ++y)
      for (int x = 0; x < proxy.width; ++x) {
        const auto i = static_cast<std::size_t>(y * proxy.width + x);
        const double from_x = static_cast<double>(proxy.x[i]), from_y = static_cast<double>(proxy.y[i]);
        EXPECT_TRUE(from_x > x * cell_x - 1.0 && from_x < (x + 1) * cell_x) << x << " " << from_x;
        EXPECT_TRUE(from_y > y * cell_y - 1.0 && from_y < (y + 1) * cell_y) << y << " " << from_y;
      }
  }
}

TEST(MovmfStartTest, HalfVectorsAreUnitAndSpreadOverTheUpperHemisphere) {
  const auto half_vectors = spread_half_vectors(256);
  ASSERT_EQ(half_vectors.size(), 256u);
  glm::dvec3 sum(0.0);
  int in_octant = 0;
  for (const glm::dvec3& h : half_vectors) {
    EXPECT_NEAR(glm::length(h), 1.0, 1e-12);
    EXPECT_GT(h.z, 0.0);
    sum += h;
    in_octant += h.y > 0.0 && h.x > h.y ? 1 : 0;
  }
  EXPECT_LT(std::abs(sum.x), 1e-12);
  EXPECT_LT(std::abs(sum.y), 1e-12);
  EXPECT_NEAR(in_octant, 32, 6);
}

}  // namespace
}  // namespace multum
