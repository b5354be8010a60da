// SPDX-License-Identifier: Apache-2.0
// Tests where errors are measured: the samples that are spread over every level, the points around these samples, and
// the texels that the points read.
#include "host/bakes/accuracy/accuracy_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

namespace multum {
namespace {

std::vector<PlaneSize> levels_of(int width, int height) {
  std::vector<PlaneSize> levels;
  for (int l = 0; (std::max(width, height) >> l) > 0; ++l)
    levels.push_back({std::max(1, width >> l), std::max(1, height >> l)});
  return levels;
}

TEST(TexelSelectionTest, NumbersTexelsRowByRow) {
  const TexelSelection texels({{5, 3}, {2, 1}, {1, 1}}, {{14, 3, 0, 3, 10}, {}, {0}});
  EXPECT_EQ(texels.slot_count(), 5u);
  EXPECT_EQ(texels.slot(0, 0), 0u);
  EXPECT_EQ(texels.slot(0, 3), 1u);
  EXPECT_EQ(texels.slot(0, 10), 2u);
  EXPECT_EQ(texels.slot(0, 14), 3u);
  EXPECT_EQ(texels.slot(2, 0), 4u);
  EXPECT_EQ(texels.column(3), 4);
  EXPECT_EQ(texels.row_begin(0, 1), 2u);
  EXPECT_EQ(texels.row_end(0, 1), 2u);
  EXPECT_EQ(texels.row_end(0, 2), 4u);
  EXPECT_EQ(texels.level_begin(1), texels.level_begin(2));
  EXPECT_EQ(texels.level_begin(3), 5u);
}

TEST(AccuracyPointsTest, EveryTexelOnceWhenAllAreWanted) {
  const std::vector<PlaneSize> levels = levels_of(22, 9);
  const AccuracyPoints points(levels, {1, 0, 1});
  std::set<std::pair<int, int>> seen;
  for (const AccuracySample& sample : points.samples()) EXPECT_TRUE(seen.insert({sample.level, sample.texel}).second);
  EXPECT_EQ(seen.size(), 11u * 4 + 5 * 2 + 2 * 1 + 1);
  EXPECT_EQ(points.texels().slot_count(), seen.size());
  EXPECT_EQ(points.chosen_count(), 0u);
}

TEST(AccuracyPointsTest, SamplesAreSpreadAndReadFewTexels) {
  const std::vector<PlaneSize> levels = levels_of(300, 200);
  const AccuracyPoints points(levels, {0, 100, 7});
  std::map<int, std::set<int>> cells;  // the stride at level 0 is 25, with one sample in each cell
  std::size_t chosen = 0;
  for (const AccuracySample& sample : points.samples()) {
    const PlaneSize size = levels[static_cast<std::size_t>(sample.level)];
    if (size.width * size.height > 100 * kWholeLevelFactor) ++chosen;
    if (sample.level == 0) cells[sample.texel / 300 / 25].insert(sample.texel % 300 / 25);
  }
  EXPECT_EQ(points.chosen_count(), chosen);
  ASSERT_EQ(cells.size(), 8u);
  for (const auto& [row, columns] : cells) EXPECT_EQ(columns.size(), 12u);
  EXPECT_LT(points.texels().slot_count(), 7 * points.samples().size());
}

// Each sample represents the texels of its cell. Together, the samples represent all texels of the level, even where
// the borders of thin levels cut the cells of the grid. If a level has few texels, all of them are samples.
TEST(AccuracyPointsTest, CellsCoverEveryLevel) {
  for (const PlaneSize map : {PlaneSize{4097, 7}, {7, 4097}, {9000, 1}, {300, 200}, {3, 3}, {1, 1}})
    for (const std::int64_t wanted : {1, 2, 50, 2048}) {
      const std::vector<PlaneSize> levels = levels_of(map.width, map.height);
      const AccuracyPoints points(levels, {0, wanted, 3});
      std::vector<std::int64_t> covered(levels.size()), counts(levels.size());
      for (const AccuracySample& sample : points.samples()) {
        covered[static_cast<std::size_t>(sample.level)] += sample.cell_texels;
        ++counts[static_cast<std::size_t>(sample.level)];
      }
      for (std::size_t l = 0; l < levels.size(); ++l) {
        const std::int64_t texel_count = std::int64_t{levels[l].width} * levels[l].height;
        const std::string where = std::to_string(levels[l].width) + " x " + std::to_string(levels[l].height);
        EXPECT_EQ(covered[l], texel_count) << where;
        if (texel_count <= kWholeLevelFactor * wanted) {
          EXPECT_EQ(counts[l], texel_count) << where;
        } else {
          EXPECT_LT(counts[l], texel_count) << where;
          EXPECT_GE(counts[l], 2) << where << ": a single sample has no spread";
        }
      }
    }
}

TEST(AccuracyPointsTest, WeightsOfEachPointSumToOne) {
  for (const std::int64_t wanted : {0, 10}) {
    const std::vector<PlaneSize> levels = levels_of(37, 20);
    const AccuracyPoints points(levels, {0, wanted, 3});
    std::vector<bool> is_read(points.texels().slot_count(), false);
    std::map<AccuracyPoint, int> counts;
    for (std::size_t i = 0; i < points.samples().size(); ++i) {
      std::vector<SamplePoint> own;
      points.append_points(i, own);
      for (const SamplePoint& point : own) {
        EXPECT_EQ(point.sample, i);
        double sum = 0.0;
        for (std::size_t t = 0; t < static_cast<std::size_t>(point.tap_count); ++t) {
          sum += point.weights[t];
          is_read.at(point.slots[t]) = true;
        }
        EXPECT_NEAR(sum, 1.0, 1e-15);
        ++counts[point.kind];
      }
    }
    EXPECT_EQ(std::count(is_read.begin(), is_read.end(), false), 0);
    EXPECT_EQ(counts[AccuracyPoint::kCentre], static_cast<int>(points.samples().size()));
    EXPECT_EQ(counts[AccuracyPoint::kBetween], counts[AccuracyPoint::kCentre] - 1);  // all levels except the coarsest
    if (wanted == 0) {
      EXPECT_EQ(counts[AccuracyPoint::kMidX], 36 * 20 + 17 * 10 + 8 * 5 + 3 * 2 + 1 * 1);
    }
  }
}

}  // namespace
}  // namespace multum
