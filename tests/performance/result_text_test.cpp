// SPDX-License-Identifier: Apache-2.0
// Tests the text of medians, quartiles, tables and commands, as in docs/evidence/BENCHMARKS.md.
#include <gtest/gtest.h>

#include "tools/lab/bench/documents/markdown_table.h"
#include "tools/lab/bench/measuring/command_text.h"
#include "tools/lab/bench/measuring/statistics.h"

namespace multum::bench {
namespace {

TEST(StatisticsTest, QuantilesOfOddAndEvenCounts) {
  const Spread odd = spread_of({5.0, 1.0, 4.0, 2.0, 3.0});
  EXPECT_EQ(odd.median, 3.0);
  EXPECT_EQ(odd.low, 2.0);
  EXPECT_EQ(odd.high, 4.0);
  const Spread even = spread_of({4.0, 1.0, 3.0, 2.0});
  EXPECT_EQ(even.median, 2.5);
  EXPECT_EQ(even.low, 1.75);
  EXPECT_EQ(even.high, 3.25);
  const Spread one = spread_of({7.0});
  EXPECT_EQ(one.median, 7.0);
  EXPECT_EQ(one.low, 7.0);
  EXPECT_EQ(one.high, 7.0);
}

TEST(StatisticsTest, JsonAndBack) {
  const Spread back = parse_spread(spread_json({2.0, 1.0, 4.0}));
  EXPECT_EQ(back.median, 2.0);
  EXPECT_EQ(back.low, 1.0);
  EXPECT_EQ(back.high, 4.0);
  EXPECT_THROW(parse_spread({{"median", 1.0}, {"quartiles", {1.0}}}), nlohmann::json::exception);
}

TEST(StatisticsTest, ThreeDigitsAndNoExponent) {
  EXPECT_EQ(rounded_text(0.0012345), "0.00123");
  EXPECT_EQ(rounded_text(1.2345), "1.23");
  EXPECT_EQ(rounded_text(12.345), "12.3");
  EXPECT_EQ(rounded_text(1234.5678), "1235");
  EXPECT_EQ(rounded_text(0.0), "0.00");
  EXPECT_EQ(spread_text({1.0, 0.9, 1.25}), "1.00 (0.90 .. 1.25)");
  EXPECT_EQ(spread_text({1.0, 0.999, 1.001}), "1.00");
}

TEST(MarkdownTableTest, ColumnsAreAsWideAsTheirWidestCell) {
  MarkdownTable table({"a", "longer"});
  table.add({"12345", "x"});
  EXPECT_EQ(table.text(),
            "| a     | longer |\n"
            "|-------|--------|\n"
            "| 12345 | x      |\n");
}

TEST(CommandTextTest, FileNamesInPlaceOfPathsAndQuotesWhereAShellWantsThem) {
  EXPECT_EQ(command_text({"/usr/bin/multum", "bake", "/home/me/map.png", "-o", "out/map.exr", "--compression=zip:4"}),
            "multum bake map.png -o out/map.exr --compression=zip:4");
  EXPECT_EQ(command_text({"bake", "", "a b", "it's", "$HOME"}), "bake '' 'a b' 'it'\\''s' '$HOME'");
}

}  // namespace
}  // namespace multum::bench
