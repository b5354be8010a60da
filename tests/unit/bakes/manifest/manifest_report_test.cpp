// SPDX-License-Identifier: Apache-2.0
// Tests the reports for build services: file names with every possible byte, the counts, and the exit code.
#include "host/bakes/manifest/manifest_report.h"

#include <gtest/gtest.h>

#include "tests/unit/foundation/base/test_folder.h"
#include "tests/unit/foundation/base/text_parts.h"

namespace multum {
namespace {

using testing::contains;

MapResult result_of(const std::string& name, MapState state, const std::string& why = "",
                    ErrorCode failure = ErrorCode::kInput) {
  MapResult result;
  result.name = name;
  result.state = state;
  result.why = why;
  result.failure = failure;
  return result;
}

ManifestOutcome outcome_of(std::vector<MapResult> results) {
  return {"maps.toml", {true, false}, std::move(results), 2.5};
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

TEST(ManifestReport, AllInPlace) {
  ManifestOutcome outcome =
      outcome_of({result_of("a.exr", MapState::kUnchanged), result_of("b.exr", MapState::kUnchanged)});
  const std::string passed = manifest_verdict(outcome);
  testing::expect_says(passed, {"multum bake --check: passed", "2 maps", "2 unchanged"});
  EXPECT_EQ(manifest_failures(outcome), "");
  EXPECT_EQ(manifest_exit_code(outcome), 0);
  EXPECT_EQ(first_line(manifest_summary(outcome)), "**" + passed + "**");
  EXPECT_FALSE(contains(manifest_junit(outcome), "<failure")) << manifest_junit(outcome);
  outcome.settings.check = false;
  outcome.results.resize(1);
  outcome.results[0].state = MapState::kBaked;
  testing::expect_says(manifest_verdict(outcome), {"multum bake: passed", "1 map ", "1 baked"});
}

TEST(ManifestReport, EachStateIsCountedListedAndInTheTable) {
  MapResult worse = result_of("w.exr", MapState::kWorse, "has an error of 30 %");
  worse.error = 0.3;
  worse.stated = 0.299999;
  worse.allowed = 0.25;
  worse.seconds = 1.5;
  worse.bytes = 1234;
  const ManifestOutcome outcome =
      outcome_of({result_of("u.exr", MapState::kUnchanged), result_of("m.exr", MapState::kMissing, "gone"),
                  result_of("s.exr", MapState::kStale, "lobes was 2 and is now 3"),
                  result_of("d.exr", MapState::kDamaged, "x"), worse, result_of("f.exr", MapState::kFailed, "no map")});
  EXPECT_EQ(manifest_failures(outcome),
            "multum bake --check: FAILED for 5 of 6 maps: 1 missing, 1 stale, 1 damaged, 1 worse, 1 failed\n"
            "  missing  m.exr: gone\n"
            "  stale    s.exr: lobes was 2 and is now 3\n"
            "  damaged  d.exr: x\n"
            "  worse    w.exr: has an error of 30 %\n"
            "  failed   f.exr: no map\n");
  const std::string summary = manifest_summary(outcome);
  EXPECT_EQ(summary.rfind("**multum bake --check: FAILED for 5 of 6 maps: ", 0), 0u) << summary;
  EXPECT_TRUE(contains(summary, "\n| w.exr | worse | 30 % | 30 % | 25 % | 1.50 | 1234 |\n")) << summary;
  EXPECT_TRUE(contains(summary, "\n| m.exr | missing | - | - | - | 0.00 | - |\n")) << summary;
  EXPECT_TRUE(contains(summary, "\n- stale: s.exr: lobes was 2 and is now 3\n")) << summary;
  EXPECT_FALSE(contains(summary, "- unchanged")) << summary;
  const std::string junit = manifest_junit(outcome);
  EXPECT_TRUE(
      contains(junit, "<testsuites name=\"multum bake\" tests=\"6\" failures=\"4\" errors=\"1\" time=\"2.500\">"))
      << junit;
  EXPECT_TRUE(contains(junit, "<property name=\"error_measured\" value=\"0.3\"/>")) << junit;
  EXPECT_TRUE(contains(junit, "<property name=\"error_stated\" value=\"0.299999\"/>")) << junit;
  EXPECT_TRUE(contains(junit, "<failure type=\"stale\" message=\"lobes was 2 and is now 3\">")) << junit;
  EXPECT_TRUE(contains(junit, "<error type=\"failed\" message=\"no map\">f.exr: no map</error>")) << junit;
}

TEST(ManifestReport, TheFirstFailureGoesBeforeFindings) {
  const MapResult stale = result_of("s", MapState::kStale);
  const MapResult input = result_of("i", MapState::kFailed, "", ErrorCode::kInput);
  const MapResult disk = result_of("e", MapState::kFailed, "", ErrorCode::kEnvironment);
  EXPECT_EQ(manifest_exit_code(outcome_of({stale})), 5);
  EXPECT_EQ(manifest_exit_code(outcome_of({stale, input, disk})), 3);
  EXPECT_EQ(manifest_exit_code(outcome_of({disk, stale, input})), 4);
}

TEST(ManifestReport, XmlTakesAnyName) {
  const auto name_in_xml = [](const std::string& name) {
    const std::string junit = manifest_junit(outcome_of({result_of(name, MapState::kUnchanged)}));
    const std::string begin = "classname=\"maps.toml\" name=\"";
    const std::size_t at = junit.find(begin) + begin.size();
    return junit.substr(at, junit.find('"', at) - at);
  };
  const std::string kLost = "\xEF\xBF\xBD";
  EXPECT_EQ(name_in_xml("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c&apos;");
  EXPECT_EQ(name_in_xml("a\tb\nc\rd"), "a&#9;b&#10;c&#13;d");
  EXPECT_EQ(name_in_xml("a\x01\x1f"
                        "b"),
            "a" + kLost + kLost + "b")
      << "XML 1.0 has no such characters";
  for (const char* whole : {"\xC3\xA4", "\xE2\x82\xAC", "\xF0\x9F\xA7\xB1", "\xED\x9F\xBF", "\xF4\x8F\xBF\xBF"})
    EXPECT_EQ(name_in_xml(whole), whole);
  EXPECT_EQ(name_in_xml("x\xFFy"), "x\uefffy");
  EXPECT_EQ(name_in_xml("x\xE2\x82"), "x\uefe2\uef82") << "cut off";
  EXPECT_EQ(name_in_xml("\xC0\xAF"), "\uefc0\uefaf") << "overlong";
  EXPECT_EQ(name_in_xml("\xED\xA0\x80"), "\uefed\uefa0\uef80") << "a surrogate";
  EXPECT_EQ(name_in_xml("\xEF\xBF\xBE"), kLost + kLost + kLost) << "U+FFFE";
  EXPECT_EQ(name_in_xml("\xF4\x90\x80\x80"), "\ueff4\uef90\uef80\uef80") << "beyond U+10FFFF";
}

TEST(ManifestReport, MarkdownTakesAnyName) {
  const ManifestOutcome outcome = outcome_of({result_of("a|b`*c*_d_\\<e>\n[f]", MapState::kStale, "x|y\nz")});
  const std::string summary = manifest_summary(outcome);
  EXPECT_TRUE(contains(summary, "\n| a\\|b\\`\\*c\\*\\_d\\_\\\\\\<e\\> \\[f\\] | stale |")) << summary;
  EXPECT_TRUE(contains(summary, ": x\\|y z\n")) << summary;
  EXPECT_TRUE(contains(manifest_failures(outcome), ": x|y z\n")) << "one line per map";
}

}  // namespace
}  // namespace multum
