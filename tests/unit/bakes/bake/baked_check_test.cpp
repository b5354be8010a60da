// SPDX-License-Identifier: Apache-2.0
// Tests when a measured error counts as worse than the error that the file states.
#include "host/bakes/bake/baked_check.h"

#include <gtest/gtest.h>

#include <cmath>

namespace multum {
namespace {

AccuracyRow row(int level, double error, const std::string& brdf = "lambert") {
  return {level, AccuracyPoint::kCentre, parse_accuracy_brdf(brdf), error, 0.0, 1};
}

FootprintError of_pixels(double error, const std::string& brdf = "lambert") {
  return {parse_accuracy_brdf(brdf), error, 0.001, error, 0, error, 100};
}

std::string worse_rows(const std::vector<AccuracyRow>& measured, const std::vector<AccuracyRow>& stated) {
  return worse_than_stated({{}, measured}, {{}, stated});
}

TEST(BakedCheck, TheWorstErrorIsTheLargest) {
  EXPECT_EQ(worst_error({}), std::nullopt);
  EXPECT_EQ(worst_error({of_pixels(0.0)}), 0.0);
  EXPECT_EQ(worst_error({of_pixels(0.1), of_pixels(0.3), of_pixels(0.2)}), 0.3);
}

TEST(BakedCheck, ErrorsOfPixelsAreHeldToo) {
  const StatedErrors stated = {{of_pixels(0.1), of_pixels(0.2, "blinn-phong:20")}, {row(0, 0.1)}};
  EXPECT_EQ(worse_than_stated(stated, stated), "");
  EXPECT_EQ(worse_than_stated({{of_pixels(0.1009)}, {}}, stated), "") << "rounding";
  EXPECT_EQ(worse_than_stated({{of_pixels(0.12), of_pixels(0.25, "blinn-phong:20")}, {row(0, 0.9)}}, stated),
            "has a pixel error of 25 % for blinn-phong:20, but its header states 20 %");
  EXPECT_EQ(worse_than_stated({{of_pixels(0.1, "ggx:0.5")}, {}}, stated), "does not state its pixel error for ggx:0.5");
  EXPECT_EQ(worse_than_stated({{of_pixels(0.9)}, {row(0, 0.1)}}, {{}, {row(0, 0.1)}}), "")
      << "earlier programs stated none";
}

TEST(BakedCheck, RoundingIsNoFinding) {
  const std::vector<AccuracyRow> stated = {row(0, 0.0), row(1, 0.5)};
  EXPECT_EQ(worse_rows(stated, stated), "");
  EXPECT_EQ(worse_rows({row(0, 0.00009), row(1, 0.505)}, stated), "")
      << "0.01 percentage points and 1 % of the error are allowed";
  EXPECT_EQ(worse_rows({row(0, 0.0), row(1, 0.1)}, stated), "") << "better is not worse";
  EXPECT_NE(worse_rows({row(0, 0.00011)}, stated), "");
  EXPECT_NE(worse_rows({row(1, 0.506)}, stated), "");
}

// Earlier versions did not state intervals, and they measured other texels.
TEST(BakedCheck, WithoutAnIntervalThereIsRoom) {
  std::vector<AccuracyRow> stated = {row(0, 0.426)};
  EXPECT_NE(worse_rows({row(0, 0.609)}, stated), "");
  stated.front().confidence = kIntervalUnstated;
  EXPECT_EQ(worse_rows({row(0, 0.609)}, stated), "");
  EXPECT_NE(worse_rows({row(0, 0.65)}, stated), "");
}

TEST(BakedCheck, TheFurthestOffIsNamed) {
  const std::vector<AccuracyRow> stated = {row(0, 0.1), row(1, 0.1), row(1, 0.1, "blinn-phong:20"), row(2, 0.1)};
  const std::vector<AccuracyRow> measured = {row(0, 0.1), row(1, 0.2), row(1, 0.4, "blinn-phong:20"), row(2, 0.3)};
  EXPECT_EQ(worse_rows(measured, stated),
            "has an error of 40 % at level 1, centre, blinn-phong:20, but its header states 10 %");
}

TEST(BakedCheck, WhatIsNotStatedIsNotHeld) {
  EXPECT_EQ(worse_rows({row(0, 0.1), row(3, 0.1)}, {row(0, 0.1)}),
            "does not state its error for level 3, centre, lambert");
}

TEST(BakedCheck, WhatIsNoNumberIsWorse) { EXPECT_NE(worse_rows({row(0, std::nan(""))}, {row(0, 0.1)}), ""); }

}  // namespace
}  // namespace multum
