// SPDX-License-Identifier: Apache-2.0
// Tests that every texel of every level is fitted in exactly one step, after the neighbours from which its initial
// lobes are computed (movmf_start.cl).
#include "host/bakes/movmf/mip_schedule.h"

#include <gtest/gtest.h>

#include <map>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {
namespace {

struct ScheduleCase {
  int width, height;
  FitOrder order;
};

class MipScheduleTest : public ::testing::TestWithParam<ScheduleCase> {
 protected:
  MipSchedule make() const {
    MovmfSettings settings;
    settings.order = GetParam().order;
    return make_mip_schedule(GetParam().width, GetParam().height, settings);
  }
};

INSTANTIATE_TEST_SUITE_P(
    Sizes, MipScheduleTest,
    ::testing::Values(ScheduleCase{64, 64, FitOrder::kColour}, ScheduleCase{64, 64, FitOrder::kScanline},
                      ScheduleCase{37, 20, FitOrder::kColour}, ScheduleCase{37, 20, FitOrder::kScanline},
                      ScheduleCase{1, 100, FitOrder::kColour}, ScheduleCase{1, 100, FitOrder::kScanline},
                      ScheduleCase{100, 1, FitOrder::kColour}, ScheduleCase{100, 1, FitOrder::kScanline},
                      ScheduleCase{1, 1, FitOrder::kColour}, ScheduleCase{2, 3, FitOrder::kScanline},
                      ScheduleCase{256, 2, FitOrder::kColour}));

// Returns the step of each texel from the steps' lists, and checks that each texel appears once.
std::map<int, int> steps_of_texels(const LevelSchedule& level) {
  std::map<int, int> step_of;
  for (int s = 0; s < level.step_count; ++s)
    for (const int texel : step_texels(level, s, 0, level.fit.height, 0))
      EXPECT_TRUE(step_of.emplace(texel, s).second) << "texel " << texel << " twice";
  return step_of;
}

// Returns whether the initial guess of a texel reads the neighbour. This is the same rule as fitted_before() in
// done_neighbours.clh.
bool reads(int other_x, int other_y, int x, int y, FitOrder order) {
  if (order == FitOrder::kScanline) return other_y < y || (other_y == y && other_x < x);
  const auto rank = [](int i, int j) {
    const int colour = (i & 1) | ((j & 1) << 1);
    return colour == 0 ? 0 : colour == 3 ? 1 : colour == 1 ? 2 : 3;
  };
  return rank(other_x, other_y) < rank(x, y);
}

TEST_P(MipScheduleTest, LevelsAreRoundDownFromTheCoarsest) {
  const MipSchedule schedule = make();
  const int count = mip_level_count(GetParam().width, GetParam().height);
  ASSERT_EQ(schedule.levels.size(), static_cast<std::size_t>(count - 1));
  for (std::size_t i = 0; i < schedule.levels.size(); ++i) {
    const LevelSchedule& level = schedule.levels[i];
    EXPECT_EQ(level.level, count - 1 - static_cast<int>(i));
    EXPECT_EQ(level.fit.width, std::max(1, GetParam().width >> level.level));
    EXPECT_EQ(level.fit.height, std::max(1, GetParam().height >> level.level));
    EXPECT_EQ(level.fit.parent_width, i == 0 ? 0 : schedule.levels[i - 1].fit.width);
    EXPECT_EQ(level.fit.parent_height, i == 0 ? 0 : schedule.levels[i - 1].fit.height);
  }
}

TEST_P(MipScheduleTest, EveryTexelOnceAndAfterTheNeighboursItReads) {
  for (const LevelSchedule& level : make().levels) {
    SCOPED_TRACE(level.level);
    const std::map<int, int> step_of = steps_of_texels(level);
    const int width = level.fit.width, height = level.fit.height;
    ASSERT_EQ(step_of.size(), static_cast<std::size_t>(width * height));
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int ny = std::max(0, y - 1); ny <= std::min(height - 1, y + 1); ++ny)
          for (int nx = std::max(0, x - 1); nx <= std::min(width - 1, x + 1); ++nx) {
            if (nx == x && ny == y) continue;
            const int own = step_of.at(y * width + x), other = step_of.at(ny * width + nx);
            ASSERT_NE(own, other) << "neighbours (" << x << ", " << y << ") and (" << nx << ", " << ny << ") race";
            EXPECT_EQ(other < own, reads(nx, ny, x, y, GetParam().order))
                << "(" << x << ", " << y << ") and (" << nx << ", " << ny << ")";
          }
  }
}

TEST_P(MipScheduleTest, SamplesCoverTheTexelAndChunksTheSamples) {
  MovmfSettings settings;
  make_reference(settings);
  settings.order = GetParam().order;
  for (const LevelSchedule& level : make_mip_schedule(GetParam().width, GetParam().height, settings).levels) {
    SCOPED_TRACE(level.level);
    const MultumMovmfFit& fit = level.fit;
    // Computes the width of the widest texel from the definition that a texel covers [x W/w, (x + 1) W/w).
    int columns = 0;
    for (int x = 0; x < fit.width; ++x) {
      int covered = 0;
      for (int i = 0; i < fit.map_width; ++i)
        covered += i * fit.width < (x + 1) * fit.map_width && (i + 1) * fit.width > x * fit.map_width ? 1 : 0;
      columns = std::max(columns, covered);
    }
    EXPECT_EQ(fit.sample_columns, columns);
    EXPECT_GE(fit.chunk_rows * fit.chunk_count, fit.sample_rows);
    EXPECT_LT(fit.chunk_rows * (fit.chunk_count - 1), fit.sample_rows) << "no empty chunk";
    const bool coarse = fit.sample_columns * fit.sample_rows > kSamplesUnchunkedMax;
    EXPECT_EQ(level.method, coarse ? FitMethod::kChunks : FitMethod::kTexels);
    EXPECT_EQ(fit.sample_capacity, coarse ? 0 : fit.sample_columns * fit.sample_rows);
    const double texels = static_cast<double>(fit.map_width) * fit.map_height / fit.width / fit.height;
    EXPECT_EQ(fit.convergence_tolerance_squared, 0.0f);
    EXPECT_TRUE(!coarse || fit.chunk_rows * fit.sample_columns <= kSamplesPerChunk || fit.chunk_rows == 1);
    EXPECT_NEAR(static_cast<double>(fit.total_weight_inverse) * texels, 1.0, 1e-6);
  }
}

TEST(MipScheduleMethodTest, CoarseTexelsAreCondensedAndSettledOnesStop) {
  for (const LevelSchedule& level : make_mip_schedule(256, 128, MovmfSettings()).levels) {
    SCOPED_TRACE(level.level);
    const bool coarse = level.level > 5;
    const bool chosen = level.level == 1;
    EXPECT_EQ(level.method, coarse ? FitMethod::kBinned : chosen ? FitMethod::kChoice : FitMethod::kTexels);
    EXPECT_EQ(level.fit.sample_capacity, coarse ? level.fit.cell_side * level.fit.cell_side : 1 << (2 * level.level));
    EXPECT_EQ(level.fit.cell_side, level.level > 6 ? kCellSide : coarse ? kCellSideFew : 0);
    EXPECT_EQ(level.fit.convergence_tolerance_squared > 0.0f, !coarse && level.level > 1);
  }
}

// movmf_choose handles only texels that have four whole normals and a parent.
TEST(MipScheduleMethodTest, FourNormalsAreGivenToLobesWhereThereIsAParentToFollow) {
  const auto finest = [](int width, int height, const MovmfSettings& settings) {
    return make_mip_schedule(width, height, settings).levels.back();
  };
  const MovmfSettings usual;
  EXPECT_EQ(finest(256, 128, usual).method, FitMethod::kChoice);
  EXPECT_EQ(finest(1000, 50, usual).method, FitMethod::kChoice) << "coarser levels cover fractions";
  EXPECT_EQ(finest(4, 2, usual).method, FitMethod::kChoice);
  EXPECT_EQ(finest(2, 2, usual).method, FitMethod::kTexels) << "no parent";
  EXPECT_EQ(finest(1, 64, usual).method, FitMethod::kTexels) << "two normals";
  EXPECT_EQ(finest(63, 64, usual).method, FitMethod::kTexels) << "fractions";
  MovmfSettings settings;
  settings.alignment = 0.2f;
  EXPECT_FLOAT_EQ(finest(64, 64, settings).fit.alignment, 0.2f * kChoiceAlignment);
  settings.alignment = 0.0f;
  EXPECT_EQ(finest(64, 64, settings).method, FitMethod::kTexels);
  settings = {};
  settings.aligned_start = false;
  EXPECT_EQ(finest(64, 64, settings).method, FitMethod::kTexels);
  settings = {};
  make_reference(settings);
  EXPECT_EQ(finest(64, 64, settings).method, FitMethod::kTexels);
  // If EM fits level 1, it runs only as many iterations as four normals need.
  const LevelSchedule em = finest(63, 64, usual);
  EXPECT_EQ(em.fit.iteration_count, kIterationsFewNormals);
  EXPECT_EQ(em.refit_iterations, MovmfSettings().refit_iterations);
}

TEST(MipScheduleFirstLevelTest, FinerLevelsAreNotScheduledAndTheOthersAreAsTheyWere) {
  MovmfSettings settings;
  const MipSchedule whole = make_mip_schedule(37, 20, settings);
  ASSERT_EQ(whole.levels.back().level, 1);
  for (const int first_level : {1, 2, 5}) {
    settings.first_level = first_level;
    const MipSchedule coarse = make_mip_schedule(37, 20, settings);
    EXPECT_EQ(coarse.weighted, whole.weighted);
    ASSERT_EQ(coarse.levels.size(), whole.levels.size() + 1 - static_cast<std::size_t>(first_level));
    for (std::size_t i = 0; i < coarse.levels.size(); ++i) {
      EXPECT_EQ(coarse.levels[i].level, whole.levels[i].level);
      EXPECT_EQ(coarse.levels[i].step_count, whole.levels[i].step_count);
    }
  }
}

// Bands of rows have the same values as the whole level, also beyond its borders.
TEST(MipScheduleStepTest, RowsBeyondABorderAreThoseOfTheLevelRepeated) {
  const LevelSchedule level = make_mip_schedule(20, 26, MovmfSettings()).levels.back();  // 10 x 13: odd
  ASSERT_EQ(level.fit.height, 13);
  for (int step = 0; step < 4; ++step) {
    std::vector<int> banded;
    for (const auto& [first, last] : {std::pair{-3, 0}, std::pair{0, 13}, std::pair{13, 15}})
      for (const int place : step_texels(level, step, first, last, -3)) banded.push_back(place);
    std::vector<int> expected;
    for (int row = -3; row < 15; ++row)
      for (const int texel : step_texels(level, step, 0, 13, 0))
        if (texel / 10 == (row + 13) % 13) expected.push_back((row + 3) * 10 + texel % 10);
    EXPECT_EQ(banded, expected) << "step " << step;
  }
}

TEST(MipScheduleStepTest, CoveredRowsFollowOneAnotherThroughTheBorders) {
  // Two levels finer than the coarsest level.
  const MultumMovmfFit fit = make_mip_schedule(8, 26, MovmfSettings()).levels[1].fit;
  for (int row = -2 * fit.height; row < 2 * fit.height; ++row) {
    EXPECT_EQ(first_covered_row(fit, row + fit.height), first_covered_row(fit, row) + fit.map_height);
    EXPECT_EQ(last_covered_row(fit, row + fit.height), last_covered_row(fit, row) + fit.map_height);
    EXPECT_GE(last_covered_row(fit, row), first_covered_row(fit, row + 1));
    EXPECT_LE(last_covered_row(fit, row), first_covered_row(fit, row + 1) + 1);
  }
}

TEST(MipScheduleWeightTest, OnlySidesThatHalveWithoutRestAreUnweighted) {
  const MovmfSettings settings;
  EXPECT_FALSE(make_mip_schedule(64, 64, settings).weighted);
  EXPECT_FALSE(make_mip_schedule(256, 2, settings).weighted);
  EXPECT_FALSE(make_mip_schedule(1, 64, settings).weighted);
  EXPECT_FALSE(make_mip_schedule(1, 1, settings).weighted);
  EXPECT_TRUE(make_mip_schedule(37, 64, settings).weighted);
  EXPECT_TRUE(make_mip_schedule(64, 100, settings).weighted) << "100 -> 50 -> 25 -> 12 has a rest";
}

TEST(MipScheduleWeightTest, ThreeTimesAPowerOfTwoHasAWholeTopLevel) {
  // The sizes are 12, 6, 3 and 1. Each of these sizes divides 12, and the only texel of the last level covers the whole
  // map.
  const MipSchedule schedule = make_mip_schedule(12, 12, MovmfSettings());
  EXPECT_FALSE(schedule.weighted);
  EXPECT_EQ(schedule.levels.front().fit.sample_columns, 12);
}

}  // namespace
}  // namespace multum
