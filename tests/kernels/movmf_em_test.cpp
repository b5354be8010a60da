// SPDX-License-Identifier: Apache-2.0
// The EM kernels against the double reference on random maps; the scalar against the vector variant, bit for bit.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include <glm/geometric.hpp>

#include "host/asset/movmf_mipmap.h"
#include "tests/kernels/em_harness.h"
#include "tests/reference/test_maps.h"

namespace multum::testing {
namespace {

// Three facets with some roughness: what EM should find.
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

std::vector<MultumVmfLobe> random_parent(const NormalMap& map, int level, int lobe_count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  const int texels = mip_level_size(map.width, level + 1) * mip_level_size(map.height, level + 1);
  std::vector<MultumVmfLobe> parent(static_cast<std::size_t>(lobe_count * texels));
  for (MultumVmfLobe& lobe : parent) {
    const glm::vec3 r =
        glm::normalize(glm::vec3(2 * uniform() - 1, 2 * uniform() - 1, 0.3f + uniform())) * (0.5f + 0.49f * uniform());
    lobe = {r.x, r.y, r.z, 1.0f / static_cast<float>(lobe_count)};
  }
  return parent;
}

struct Case {
  int width, height, level, lobes;
  bool force_chunked;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.width << "x" << c.height << " level " << c.level << ", " << c.lobes << " lobes"
       << (c.force_chunked ? ", chunked" : "");
}

class MovmfEmTest : public ::testing::TestWithParam<Case> {};

// Tolerances. One E-step in fp32 errs by some 1e-6 in each sum; EM amplifies that by at most the growth of its
// differences between iterations, below 10 over 4 iterations on these maps: 2e-5 would do, 1e-4 is asserted for (a r,
// a), except that 1 lobe in 200 may be where two lobes compete evenly (then 1e-2).
TEST_P(MovmfEmTest, EqualsReference) {
  const Case c = GetParam();
  const unsigned seed = 20061u + static_cast<unsigned>(c.width * 7 + c.level);
  SCOPED_TRACE(seed);
  const NormalMap map = random_map(c.width, c.height, seed);
  const auto parent = random_parent(map, c.level, c.lobes, seed + 1);
  LevelFit how;
  how.level = c.level;
  how.iterations = 4;
  how.force_chunked = c.force_chunked;
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
  const auto parent = random_parent(map, c.level, c.lobes, 78);
  LevelFit how;
  how.level = c.level;
  how.force_chunked = c.force_chunked;
  const auto vector = fit_with_kernels(map, parent, c.lobes, how);
  how.scalar = true;
  const auto scalar = fit_with_kernels(map, parent, c.lobes, how);
  ASSERT_EQ(vector.size(), scalar.size());
  EXPECT_EQ(0, std::memcmp(vector.data(), scalar.data(), vector.size() * sizeof(MultumVmfLobe)));
}

INSTANTIATE_TEST_SUITE_P(Maps, MovmfEmTest,
                         ::testing::Values(Case{32, 32, 1, 4, false}, Case{32, 32, 2, 6, false},
                                           Case{64, 32, 3, 1, false}, Case{32, 32, 3, 8, false},
                                           Case{64, 64, 5, 4, true}, Case{128, 128, 6, 4, true},
                                           Case{20, 12, 1, 4, false}, Case{37, 21, 2, 3, false},
                                           Case{21, 37, 3, 4, true}, Case{1, 37, 1, 4, false}, Case{64, 1, 3, 2, false},
                                           Case{50, 70, 2, 2, true}));

// Both ways to sum must agree: which one runs is a matter of a texel's size alone.
TEST(MovmfEmPathTest, ChunkedAgreesWithUnchunked) {
  const NormalMap map = random_map(64, 64, 5);
  const auto parent = random_parent(map, 4, 4, 6);
  LevelFit how;
  how.level = 4;
  const auto unchunked = fit_with_kernels(map, parent, 4, how);
  how.force_chunked = true;
  const auto chunked = fit_with_kernels(map, parent, 4, how);
  for (std::size_t i = 0; i < chunked.size(); ++i) {
    EXPECT_NEAR(chunked[i].amplitude, unchunked[i].amplitude, 1e-4);
    EXPECT_NEAR(chunked[i].mean_z * chunked[i].amplitude, unchunked[i].mean_z * unchunked[i].amplitude, 1e-4);
  }
}

}  // namespace
}  // namespace multum::testing
