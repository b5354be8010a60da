// SPDX-License-Identifier: Apache-2.0
// Tests that a bake in bands of rows gives the same bytes as a bake of the whole map at once (movmf_level_fit.h). The
// bands have any height, and the planes are in memory or in files.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <random>

#include "host/bakes/movmf/movmf_bake.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/error.h"
#include "tests/fixtures/test_device.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::test_device;

struct Case {
  int width, height;
  bool periodic, colours;
  CoarseNormals coarse;
  int first_level;
  bool materials = false;  // four weights, and shortened normals
  Representation representation = Representation::kMovmf;
  bool refine = false;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << (c.materials ? "materials, " : "") << c.width << " x " << c.height << (c.periodic ? " periodic" : "")
       << (c.colours ? " colours" : "") << (c.coarse == CoarseNormals::kAll ? " all" : " binned") << " from level "
       << c.first_level << (c.representation == Representation::kGmm ? ", Gaussians" : "")
       << (c.refine ? ", refined" : "");
}

std::array<std::vector<float>, 3> random_planes(const Case& c, unsigned seed, bool unit) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24; };
  std::array<std::vector<float>, 3> planes;
  for (int i = 0; i < c.width * c.height; ++i) {
    glm::dvec3 v(uniform(), uniform(), uniform());
    if (unit) v = glm::normalize(glm::dvec3(2.0 * v.x - 1.0, 2.0 * v.y - 1.0, 0.2 + v.z));
    if (unit && c.materials) v *= 1.0 - 0.5 * std::pow(uniform(), 4.0);
    for (int p = 0; p < 3; ++p) planes[static_cast<std::size_t>(p)].push_back(static_cast<float>(v[p]));
  }
  return planes;
}

void fill(PlaneStore& store, const std::array<std::vector<float>, 3>& planes) {
  store.write_rows(0, store.height(), {planes[0].data(), planes[1].data(), planes[2].data()});
}

template <typename Vector>
void expect_same(const std::vector<std::vector<Vector>>& a, const std::vector<std::vector<Vector>>& b,
                 const std::string& where) {
  ASSERT_EQ(a.size(), b.size()) << where;
  for (std::size_t j = 0; j < a.size(); ++j) {
    ASSERT_EQ(a[j].size(), b[j].size()) << where;
    for (std::size_t i = 0; i < a[j].size(); ++i)
      ASSERT_EQ(std::memcmp(&a[j][i], &b[j][i], sizeof(Vector)), 0) << where << " lobe " << j << " texel " << i;
  }
}

void expect_same(const MovmfMipmap& a, const MovmfMipmap& b, const std::string& what) {
  ASSERT_EQ(a.levels.size(), b.levels.size());
  for (std::size_t l = 0; l < a.levels.size(); ++l) {
    const std::string where = what + ", level " + std::to_string(l);
    expect_same(a.levels[l].lobes, b.levels[l].lobes, where);
    expect_same(a.levels[l].colours, b.levels[l].colours, where);
    expect_same(a.levels[l].weights, b.levels[l].weights, where);
  }
}

class BakeBandsTest : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const Case& c = GetParam();
    normals_.emplace(c.width, c.height);
    fill(*normals_, random_planes(c, 1, true));
    inputs_.normals = &*normals_;
    if (c.colours) {
      albedo_.emplace(c.width, c.height);
      fill(*albedo_, random_planes(c, 2, false));
    }
    if (c.materials) {
      weights_.count = 4;
      for (unsigned seed : {3u, 4u})
        fill(weights_.rgb_planes.emplace_back(c.width, c.height), random_planes(c, seed, false));
      normals_->set_shortened(true);
    }
    inputs_.features = FeaturePlanes::of(albedo_ ? &*albedo_ : nullptr, c.materials ? &weights_ : nullptr);
    settings_.representation = c.representation;
    settings_.lobe_count = 2;
    settings_.iteration_count = settings_.iteration_count_coarse = settings_.iteration_count_top = 3;
    settings_.refit_iterations = 2;
    settings_.search_start = false;
    settings_.periodic_x = settings_.periodic_y = c.periodic;
    settings_.coarse_normals = c.coarse;
    settings_.first_level = c.first_level;
    settings_.refine = c.refine;
    report_.plan = "";
  }

  MovmfMipmap bake() {
    report_ = FitReport();
    return bake_movmf(test_device(), inputs_, settings_, report_, nullptr);
  }

  struct Whole {
    MovmfMipmap mipmap;
    std::string plan;
  };
  // Returns the bake of the whole map at once in memory. All tests of this map share it.
  const Whole& whole() {
    static std::map<std::string, Whole> baked;
    Whole& mine = baked[::testing::PrintToString(GetParam())];
    if (mine.mipmap.levels.empty()) {
      mine.mipmap = bake();
      mine.plan = report_.plan;
    }
    return mine;
  }

  std::optional<PlaneStore> normals_, albedo_;
  WeightMap weights_;
  MapInputs inputs_;
  MovmfSettings settings_;
  FitReport report_;
};

INSTANTIATE_TEST_SUITE_P(
    Maps, BakeBandsTest,
    ::testing::Values(
        Case{64, 256, true, false, CoarseNormals::kBinned, 0}, Case{64, 256, false, true, CoarseNormals::kAll, 0},
        Case{50, 237, true, true, CoarseNormals::kBinned, 0}, Case{37, 190, true, false, CoarseNormals::kAll, 0},
        Case{101, 99, false, false, CoarseNormals::kBinned, 1}, Case{96, 2000, true, true, CoarseNormals::kBinned, 4},
        Case{70, 1900, false, false, CoarseNormals::kBinned, 4}, Case{70, 160, false, true, CoarseNormals::kAll, 5},
        Case{96, 1000, true, false, CoarseNormals::kBinned, 2, false, Representation::kMovmf, true},
        Case{70, 1100, false, true, CoarseNormals::kBinned, 3, false, Representation::kMovmf, true},
        Case{61, 240, true, true, CoarseNormals::kBinned, 0, true},
        Case{50, 237, true, true, CoarseNormals::kBinned, 0, false, Representation::kGmm},
        Case{37, 190, true, true, CoarseNormals::kAll, 0, true, Representation::kGmm},
        Case{61, 240, true, true, CoarseNormals::kBinned, 0, true, Representation::kGmm}));

TEST_P(BakeBandsTest, AnyMemoryGivesTheSameBytes) {
  const auto& [mipmap, plan] = whole();
  int tried = 0;
  for (std::uint64_t memory = std::uint64_t{16} << 10; tried < 4; memory += memory / 3) {
    ASSERT_LT(memory, std::uint64_t{1} << 28);
    inputs_.memory_bytes = memory;
    MovmfMipmap banded;
    try {
      banded = bake();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage) << error.what();
      EXPECT_NE(std::string(error.what()).find("--memory"), std::string::npos) << error.what();
      continue;
    }
    ++tried;
    EXPECT_NE(report_.plan, plan) << "bands were expected";
    expect_same(banded, mipmap, std::to_string(memory >> 10) + " KiB");
  }
}

TEST_P(BakeBandsTest, ScratchFilesAndThreadsGiveTheSameBytes) {
  const MovmfMipmap& in_memory = whole().mipmap;
  inputs_.spill.memory_bytes = 0;
  inputs_.spill.scratch_folder = ::testing::TempDir();
  inputs_.threads = 3;
  PlaneStore stored(GetParam().width, GetParam().height, ::testing::TempDir());
  fill(stored, random_planes(GetParam(), 1, true));
  stored.set_shortened(GetParam().materials);
  inputs_.normals = &stored;
  expect_same(bake(), in_memory, "scratch files");
}

TEST_P(BakeBandsTest, ScalarKernelsGiveTheSameBytes) {
  const MovmfMipmap& vectors = whole().mipmap;
  test_device().set_shape(LaunchShape::of_accelerator(test_device().info()));
  expect_same(bake(), vectors, "scalar");
  test_device().set_shape(LaunchShape::of(test_device().info()));
}

}  // namespace
}  // namespace multum
