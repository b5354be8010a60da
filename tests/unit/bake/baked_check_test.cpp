// SPDX-License-Identifier: Apache-2.0
// When a measured error is worse than what a file states of itself.
#include "host/bake/baked_check.h"

#include <gtest/gtest.h>

#include <cmath>

namespace multum {
namespace {

AccuracyRow row(int level, double error, const std::string& brdf = "lambert") {
  return {level, AccuracyPoint::kCentre, parse_accuracy_brdf(brdf), error, 0.0, 1};
}

TEST(BakedCheck, TheWorstErrorIsTheLargest) {
  EXPECT_EQ(worst_error({}), std::nullopt);
  EXPECT_EQ(worst_error({row(0, 0.0)}), 0.0);
  EXPECT_EQ(worst_error({row(0, 0.1), row(1, 0.3), row(2, 0.2)}), 0.3);
}

TEST(BakedCheck, RoundingIsNoFinding) {
  const std::vector<AccuracyRow> stated = {row(0, 0.0), row(1, 0.5)};
  EXPECT_EQ(worse_than_stated(stated, stated), "");
  EXPECT_EQ(worse_than_stated({row(0, 0.00009), row(1, 0.505)}, stated), "") << "0.01 points, and 1 % of the error";
  EXPECT_EQ(worse_than_stated({row(0, 0.0), row(1, 0.1)}, stated), "") << "better is not worse";
  EXPECT_NE(worse_than_stated({row(0, 0.00011)}, stated), "");
  EXPECT_NE(worse_than_stated({row(1, 0.506)}, stated), "");
}

// Earlier programs stated no intervals, and looked at other texels.
TEST(BakedCheck, WithoutAnIntervalThereIsRoom) {
  std::vector<AccuracyRow> stated = {row(0, 0.426)};
  EXPECT_NE(worse_than_stated({row(0, 0.609)}, stated), "");
  stated.front().confidence = kIntervalUnstated;
  EXPECT_EQ(worse_than_stated({row(0, 0.609)}, stated), "");
  EXPECT_NE(worse_than_stated({row(0, 0.65)}, stated), "");
}

TEST(BakedCheck, TheFurthestOffIsNamed) {
  const std::vector<AccuracyRow> stated = {row(0, 0.1), row(1, 0.1), row(1, 0.1, "blinn-phong:20"), row(2, 0.1)};
  const std::vector<AccuracyRow> measured = {row(0, 0.1), row(1, 0.2), row(1, 0.4, "blinn-phong:20"), row(2, 0.3)};
  EXPECT_EQ(worse_than_stated(measured, stated), "is 40 % off at level 1, centre, blinn-phong:20, states 10 %");
}

TEST(BakedCheck, WhatIsNotStatedIsNotHeld) {
  EXPECT_EQ(worse_than_stated({row(0, 0.1), row(3, 0.1)}, {row(0, 0.1)}),
            "states no error for level 3, centre, lambert");
}

TEST(BakedCheck, WhatIsNoNumberIsWorse) { EXPECT_NE(worse_than_stated({row(0, std::nan(""))}, {row(0, 0.1)}), ""); }

}  // namespace
}  // namespace multum
