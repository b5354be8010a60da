// SPDX-License-Identifier: Apache-2.0
// Every texel of every level is fitted in exactly one step, after the neighbours that its start reads (movmf_start.cl).
#include "host/bake/mip_schedule.h"

#include <gtest/gtest.h>

#include <map>

#include "host/asset/movmf_mipmap.h"

namespace multum {
namespace {

struct Case {
  int width, height;
  FitOrder order;
};

class MipScheduleTest : public ::testing::TestWithParam<Case> {
 protected:
  MipSchedule make() const {
    MovmfSettings settings;
    settings.order = GetParam().order;
    return make_mip_schedule(GetParam().width, GetParam().height, settings);
  }
};

INSTANTIATE_TEST_SUITE_P(Sizes, MipScheduleTest,
                         ::testing::Values(Case{64, 64, FitOrder::kColour}, Case{64, 64, FitOrder::kScanline},
                                           Case{37, 20, FitOrder::kColour}, Case{37, 20, FitOrder::kScanline},
                                           Case{1, 100, FitOrder::kColour}, Case{1, 100, FitOrder::kScanline},
                                           Case{100, 1, FitOrder::kColour}, Case{100, 1, FitOrder::kScanline},
                                           Case{1, 1, FitOrder::kColour}, Case{2, 3, FitOrder::kScanline},
                                           Case{256, 2, FitOrder::kColour}));

// The step of each texel, from the lists; checks that each texel is there once and that gaps hold -1.
std::map<int, int> steps_of_texels(const LevelSchedule& level) {
  std::map<int, int> step_of;
  std::size_t end = 0;
  for (std::size_t s = 0; s < level.steps.size(); ++s) {
    const FitStep& step = level.steps[s];
    EXPECT_EQ(static_cast<std::size_t>(step.list_offset), end) << "steps follow one another";
    EXPECT_EQ(step.list_offset % MULTUM_GROUP, 0) << "and start at a group";
    const int groups = (step.texel_count + MULTUM_GROUP - 1) / MULTUM_GROUP;
    end += static_cast<std::size_t>(groups * MULTUM_GROUP);
    for (int i = 0; i < groups * MULTUM_GROUP; ++i) {
      const int texel = level.texel_list.at(static_cast<std::size_t>(step.list_offset + i));
      if (i >= step.texel_count) {
        EXPECT_EQ(texel, -1);
      } else {
        EXPECT_TRUE(step_of.emplace(texel, static_cast<int>(s)).second) << "texel " << texel << " twice";
      }
    }
  }
  EXPECT_EQ(end, level.texel_list.size());
  return step_of;
}

// movmf_start.cl, fitted_before(): which neighbours a texel's start reads.
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
  for (const LevelSchedule& level : make().levels) {
    SCOPED_TRACE(level.level);
    const MultumMovmfFit& fit = level.fit;
    // The widest texel, by its own definition: [x W/w, (x + 1) W/w).
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
    EXPECT_EQ(fit.settled_change_squared, 0.0f);
    EXPECT_TRUE(!coarse || fit.chunk_rows * fit.sample_columns <= kSamplesPerChunk || fit.chunk_rows == 1);
    EXPECT_NEAR(static_cast<double>(fit.total_weight_inverse) * texels, 1.0, 1e-6);
  }
}

TEST(MipScheduleMethodTest, FastCondensesCoarseTexelsAndStopsSettledOnes) {
  MovmfSettings settings;
  make_fast(settings);
  for (const LevelSchedule& level : make_mip_schedule(256, 128, settings).levels) {
    SCOPED_TRACE(level.level);
    const bool coarse = level.level > 5;
    EXPECT_EQ(level.method, coarse ? FitMethod::kCondensed : FitMethod::kTexels);
    EXPECT_EQ(level.fit.sample_capacity, coarse ? MULTUM_CELL_COUNT : 1 << (2 * level.level));
    EXPECT_EQ(level.fit.settled_change_squared > 0.0f, !coarse && level.level > 1);
    if (level.level == 1) {
      EXPECT_EQ(level.fit.iteration_count, kIterationsFewNormals);
      EXPECT_EQ(level.iteration_count_again, kIterationsFewNormals);
    }
  }
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
      EXPECT_EQ(coarse.levels[i].texel_list, whole.levels[i].texel_list);
    }
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
  // 12 -> 6 -> 3 -> 1: every level divides 12, the last by covering all of it.
  const MipSchedule schedule = make_mip_schedule(12, 12, MovmfSettings());
  EXPECT_FALSE(schedule.weighted);
  EXPECT_EQ(schedule.levels.front().fit.sample_columns, 12);
}

}  // namespace
}  // namespace multum
