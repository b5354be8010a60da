// SPDX-License-Identifier: Apache-2.0
// Tests the measured time of a bake, which time budgets limit.
#include "host/bakes/bake/bake_report.h"

#include <gtest/gtest.h>

namespace multum {
namespace {

TEST(BakeReportTest, MeasuringAndChoosingAreNoPartOfABake) {
  BakeReport report;
  report.stages = {{"read", 1.0}, {"choose", 16.0}, {"fit", 2.0}, {"measure", 8.0}, {"write", 4.0}};
  EXPECT_EQ(report.bake_seconds(), 7.0);
}

}  // namespace
}  // namespace multum
