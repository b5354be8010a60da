// SPDX-License-Identifier: Apache-2.0
// Tests that Pareto fronts compare work and not elapsed time, so that other load on the machine does not matter.
#include <gtest/gtest.h>

#include "host/bakes/settings_search/tradeoff_sweep.h"

namespace multum {
namespace {

// Makes a measured row whose error is exact.
TradeoffRow made_row(double error, const RunTime& bake, double frame_ms, double frame_work_ms) {
  TradeoffRow row;
  row.reached.error = error;
  row.has_error = true;
  row.bake = bake;
  row.frame_ms = frame_ms;
  row.frame_work_ms = frame_work_ms;
  row.gpu_bytes = 100;
  return row;
}

TEST(TradeoffFrontsTest, ElapsedTimeDecidesNothing) {
  // The second row has half the error and needs twice the work. Other programs slowed down the first row, so it took
  // longer.
  std::vector<TradeoffRow> rows = {made_row(0.2, {1.0, 90.0, 0.0}, 500.0, 4.0),
                                   made_row(0.1, {2.0, 3.0, 0.0}, 20.0, 8.0), made_row(0.3, {2.0, 0.1, 0.0}, 0.1, 8.0)};
  mark_fronts(rows, {0.05, 0.05});
  EXPECT_TRUE(rows[0].on_time_front && rows[0].on_frame_front) << "the least work";
  EXPECT_TRUE(rows[1].on_time_front && rows[1].on_frame_front) << "the least error";
  EXPECT_FALSE(rows[2].on_time_front || rows[2].on_frame_front)
      << "more error for the same work, although it took less time";
}

TEST(TradeoffFrontsTest, ADevicesWorkCountsAsProcessorsWorkDoes) {
  std::vector<TradeoffRow> rows = {made_row(0.2, {0.1, 1.0, 5.0}, 1.0, 1.0), made_row(0.2, {1.0, 9.0, 0.5}, 1.0, 1.0)};
  mark_fronts(rows, {0.05, 0.05});
  EXPECT_FALSE(rows[0].on_time_front);
  EXPECT_TRUE(rows[1].on_time_front);
}

TEST(TradeoffFrontsTest, AFrameThatWasNotDrawnIsOnNoFrontOfFrames) {
  std::vector<TradeoffRow> rows = {made_row(0.2, {1.0, 1.0, 0.0}, -1.0, -1.0)};
  mark_fronts(rows, {0.05, 0.05});
  EXPECT_TRUE(rows[0].on_time_front && rows[0].on_size_front);
  EXPECT_FALSE(rows[0].on_frame_front);
}

}  // namespace
}  // namespace multum
