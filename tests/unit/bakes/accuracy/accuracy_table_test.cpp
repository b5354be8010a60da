// SPDX-License-Identifier: Apache-2.0
// Tests measured errors as people read them and as files store them. Other text in the attribute is returned unchanged.
#include "host/bakes/accuracy/accuracy_table.h"
#include "host/formats/asset/averages/moment_file.h"

#include <gtest/gtest.h>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {
namespace {

std::vector<AccuracyRow> some_rows() {
  std::vector<AccuracyRow> rows;
  for (const char* brdf : {"blinn-phong:500", "lambert", "blinn-phong:500 coloured", "lambert coloured"}) {
    rows.push_back({0, AccuracyPoint::kCentre, parse_accuracy_brdf(brdf), 0.0123456, 0.0010000004, 4});
    rows.push_back({0, AccuracyPoint::kMidX, parse_accuracy_brdf(brdf), 0.02, 0.001, 4});
    rows.push_back({0, AccuracyPoint::kMidY, parse_accuracy_brdf(brdf), 0.03, 0.001, 4});
    rows.push_back({0, AccuracyPoint::kBetween, parse_accuracy_brdf(brdf), 0.9, 0.001, 4});
    rows.push_back({1, AccuracyPoint::kCentre, parse_accuracy_brdf(brdf), 0.05, 0.0, 1});
  }
  return rows;
}

TEST(AccuracyTable, OneForWhiteAndOneForColours) {
  EXPECT_EQ(
      accuracy_table(some_rows()),
      "measured error, relative L1 in %, at texel centres | midway between texels (the worse of x and y); +- 95 % "
      "interval\n"
      "  level    texels                 blinn-phong:500                         lambert\n"
      "      0   sampled     1.23 +- 0.11 | 3.00 +- 0.10     1.23 +- 0.11 | 3.00 +- 0.10\n"
      "      1       all                        5.00 | -                        5.00 | -\n"
      "measured error with colours, relative L1 in %, at texel centres | midway between texels (the worse of x "
      "and y); +- 95 % interval\n"
      "  level    texels                 blinn-phong:500                         lambert\n"
      "      0   sampled     1.23 +- 0.11 | 3.00 +- 0.10     1.23 +- 0.11 | 3.00 +- 0.10\n"
      "      1       all                        5.00 | -                        5.00 | -\n");
  EXPECT_EQ(accuracy_table({}), "");
}

TEST(AccuracyTable, TheAttributeGivesBackTheTable) {
  const std::string json = measured_error_json(some_rows());
  EXPECT_EQ(json.substr(0, 55), "[[0,\"centre\",\"blinn-phong:500\",0.012346,0.001001],[0,\"m");
  EXPECT_EQ(json.substr(json.size() - 39), "[1,\"centre\",\"lambert coloured\",0.05,0]]") << "all texels";
  const auto parsed = parse_measured_error(json);
  ASSERT_TRUE(parsed.has_value());
  EXPECT_EQ(measured_error_json(parsed->rows), json);
  EXPECT_EQ(accuracy_table(parsed->rows), accuracy_table(some_rows()));
  EXPECT_TRUE(parsed->footprint_errors.empty()) << "files of earlier programs have no such errors";
  EXPECT_TRUE(parse_measured_error("[]")->rows.empty());
}

TEST(AccuracyTable, ErrorsOfPixelsComeFirst) {
  const std::vector<FootprintError> errors = {
      {AccuracyBrdf::blinn_phong(100.0), 0.0912345, 0.0021001, 0.2134567, 1, 0.3012345, 2560},
      {AccuracyBrdf::lambert(), 0.01, 0.0, 0.02, 0, 0.03, 2560}};
  const std::string json = measured_error_json(some_rows(), errors);
  EXPECT_TRUE(
      json.starts_with("[[-1,\"pixels\",\"blinn-phong:100\",0.091235,0.002101,0.213457,1,0.301235,2560],"
                       "[-1,\"pixels\",\"lambert\",0.01,0.0,0.02,0,0.03,2560],[0,\"centre\","))
      << json;
  const auto parsed = parse_measured_error(json);
  ASSERT_TRUE(parsed.has_value());
  EXPECT_EQ(parsed->rows.size(), some_rows().size());
  EXPECT_EQ(measured_error_json(parsed->rows, parsed->footprint_errors), json);
  EXPECT_EQ(footprint_error_text(errors),
            "relative L1 error of pixels with its 95 % interval\n"
            "  blinn-phong:100  9.12 +- 0.22 %; 95 % of pixels within 21.35 %; worst: 30.12 % for pixels that cover 2 "
            "to 4 texels\n"
            "  lambert          1.00 +- 0.00 %; 95 % of pixels within 2.00 %; worst: 3.00 % for pixels that cover 1 to "
            "2 texels\n");
  EXPECT_EQ(footprint_error_text(parsed->footprint_errors), footprint_error_text(errors)) << "from bake and file";
  EXPECT_EQ(footprint_error_text({}), "");
}

// A writer of rows reserves space for the table before any error is measured. Tests that this space is enough for the
// longest table of each representation.
TEST(AccuracyTable, TheLongestFitsIntoTheRoomOfAHeader) {
  const auto longest = [](const std::vector<std::string>& ways) {
    std::vector<AccuracyRow> rows;
    for (int level = 0; level < 16; ++level)
      for (const AccuracyPoint point :
           {AccuracyPoint::kCentre, AccuracyPoint::kMidX, AccuracyPoint::kMidY, AccuracyPoint::kBetween})
        for (const std::string& way : ways)
          for (const std::string brdf : {"blinn-phong:20", "blinn-phong:100", "blinn-phong:500", "lambert"})
            for (const char* coloured : {"", " coloured"})
              rows.push_back({level, point, parse_accuracy_brdf(brdf + way + coloured), 0.123456, 0.012345, 1});
    std::vector<FootprintError> errors;
    for (std::size_t i = 0; i < rows.size() / 64; ++i)
      errors.push_back({rows[i].brdf, 0.123456, 0.012345, 0.123456, 14, 0.123456, 123456});
    return measured_error_json(rows, errors).size();
  };
  EXPECT_LE(longest({""}), static_cast<std::size_t>(BakedWriteOptions().measured_error_bytes));
  EXPECT_LE(longest({" toksvig", " lean", " lean-jacobian"}), static_cast<std::size_t>(kMomentErrorBytes));
}

// There is one table for each way of shading, with and without colours. Each table has one column per BRDF.
TEST(AccuracyTable, WaysOfShadingHaveTablesOfTheirOwn) {
  const std::vector<AccuracyRow> rows = {
      {0, AccuracyPoint::kCentre, parse_accuracy_brdf("lambert toksvig"), 0.125, 0.0, 1},
      {0, AccuracyPoint::kCentre, parse_accuracy_brdf("lambert toksvig coloured"), 0.25, 0.0, 1},
      {0, AccuracyPoint::kCentre, parse_accuracy_brdf("lambert lean"), 0.5, 0.0, 1}};
  const std::string text = accuracy_table(rows);
  std::size_t at = 0;
  for (const char* part : {"measured error of toksvig, relative", "12.50", "measured error of toksvig with colours, ",
                           "25.00", "measured error of lean, relative", "50.00"}) {
    const std::size_t found = text.find(part, at);
    ASSERT_NE(found, std::string::npos) << part << " is missing or out of order in\n" << text;
    at = found;
  }
}

// Rounding first to six digits and then to four digits may give another result than rounding directly to four digits.
TEST(AccuracyTable, RoundsAlikeFromBakeAndFile) {
  const std::vector<AccuracyRow> rows = {
      {0, AccuracyPoint::kCentre, parse_accuracy_brdf("lambert"), 0.0001499996, 0.0, 1}};
  EXPECT_EQ(accuracy_table(parse_measured_error(measured_error_json(rows))->rows), accuracy_table(rows));
}

TEST(AccuracyBrdf, HasTheTextThatItIsReadFrom) {
  for (const char* text :
       {"lambert", "lambert coloured", "lambert lean", "blinn-phong:20", "blinn-phong:33.3", "blinn-phong:1e+05",
        "blinn-phong:500 lean-jacobian coloured", "roughness", "roughness toksvig", "ggx:0.40", "ggx:0.5 coloured"})
    EXPECT_EQ(parse_accuracy_brdf(text).text(), text);
  const AccuracyBrdf read = parse_accuracy_brdf("blinn-phong:33.3 lean coloured");
  EXPECT_EQ(read, (AccuracyBrdf{AccuracyBrdfKind::kBlinnPhong, 33.3, "", "lean", true}));
  EXPECT_TRUE(read.is_same_brdf(AccuracyBrdf::blinn_phong(33.3)));
  EXPECT_FALSE(read.is_same_brdf(AccuracyBrdf::blinn_phong(33.0)));
  EXPECT_EQ(parse_accuracy_brdf("roughness").kind, AccuracyBrdfKind::kRoughness);
  EXPECT_EQ(parse_accuracy_brdf("ggx:0.5 lean"),
            (AccuracyBrdf{AccuracyBrdfKind::kNamed, 0.0, "ggx:0.5", "lean", false}));
  EXPECT_EQ(AccuracyBrdf::named("my paint.brdf").text(), "my_paint.brdf");
  // Text that does not come from our programs is returned unchanged.
  for (const char* text : {"", " ", "blinn-phong:2e1", "blinn-phong:", "blinn-phong:20x lean", "lambert ", " coloured"})
    EXPECT_EQ(parse_accuracy_brdf(text).text(), text);
}

// Files of earlier versions have four fields per entry.
TEST(AccuracyTable, IntervalsMayBeUnstated) {
  const std::string json = "[[0,\"centre\",\"lambert\",0.125]]";
  const auto stated = parse_measured_error(json);
  ASSERT_TRUE(stated.has_value());
  EXPECT_EQ(stated->rows.front().confidence, kIntervalUnstated);
  EXPECT_EQ(measured_error_json(stated->rows), json);
  EXPECT_EQ(accuracy_table(stated->rows),
            "measured error, relative L1 in %, at texel centres | midway between texels (the worse of x and y)\n"
            "  level    texels             lambert\n"
            "      0  unstated           12.50 | -\n");
}

// An interval of samples never rounds to 0, which would say that all texels were measured.
TEST(AccuracyTable, IntervalsAreRoundedUp) {
  const std::vector<AccuracyRow> rows = {
      {0, AccuracyPoint::kCentre, parse_accuracy_brdf("lambert"), 0.0, kIntervalMin, 9},
      {1, AccuracyPoint::kCentre, parse_accuracy_brdf("lambert"), 0.1, 0.0012, 9},
      {2, AccuracyPoint::kCentre, parse_accuracy_brdf("lambert"), 0.1, 0.00120001, 9},
      {3, AccuracyPoint::kCentre, parse_accuracy_brdf("lambert"), 0.1, 0.0, 9}};
  EXPECT_EQ(measured_error_json(rows),
            "[[0,\"centre\",\"lambert\",0.0,1e-06],[1,\"centre\",\"lambert\",0.1,0.0012],"
            "[2,\"centre\",\"lambert\",0.1,0.001201],[3,\"centre\",\"lambert\",0.1,0]]");
  const std::string table = accuracy_table(rows);
  for (const char* part : {" 0.00 +- 0.01 | -", "10.00 +- 0.12 | -", "10.00 +- 0.13 | -", " 10.00 | -"})
    EXPECT_NE(table.find(part), std::string::npos) << part << " is missing from\n" << table;
  EXPECT_EQ(table, accuracy_table(parse_measured_error(measured_error_json(rows))->rows));
}

TEST(AccuracyTable, OtherTextsAreNoErrors) {
  for (const char* text :
       {"", "{}", "nonsense", "[1]", "[[0,\"centre\",\"lambert\"]]", "[[0,\"middle\",\"lambert\",0.1]]",
        "[[1000000000,\"centre\",\"lambert\",0.1]]", "[[-1,\"centre\",\"lambert\",0.1]]",
        "[[0.5,\"centre\",\"lambert\",0.1]]", "[[0,\"centre\",\"lambert\",0.1,-0.1]]",
        "[[0,\"centre\",\"lambert\",0.1,\"all\"]]", "[[0,\"centre\",\"lambert\",0.1,0,0]]",
        "[[0,\"centre\",\"lambert\",\"0.1\"]]", "[[-1,\"pixels\",\"lambert\",0.1]]",
        "[[-1,\"pixels\",\"lambert\",0.1,0,0,64,0,1]]", "[[-1,\"pixels\",\"lambert\",0.1,0,-1,0,0,1]]",
        "[[-1,\"pixels\",\"lambert\",0.1,0,0,0.5,0,1]]"})
    EXPECT_FALSE(parse_measured_error(text).has_value()) << text;
}

}  // namespace
}  // namespace multum
