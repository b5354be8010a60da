// SPDX-License-Identifier: Apache-2.0
// Tests bakes with a target. If the bake cannot meet the target, it fails and states the best result. With
// --best-effort, it also writes the file.
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "host/bakes/accuracy/footprints.h"
#include "host/formats/asset/baked_file.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class TargetCommandTest : public CliTest {
 protected:
  TargetCommandTest() { make_map("map", 32); }
  ProgramResult bake(std::vector<std::string> options) {
    options.insert(options.begin(), {"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--green", "up"});
    return multum(options);
  }
  bool is_written() const { return folder_.names().contains("map.ndf.exr"); }
};

TEST_F(TargetCommandTest, MeetsAnErrorAndSaysHow) {
  const ProgramResult met = bake({"--target-error", "0.3", "--report", path("map.json")});
  ASSERT_EQ(met.exit_code, 0) << met.err;
  EXPECT_TRUE(std::regex_search(met.out, std::regex("chosen: --ndf \\S+ .* for blinn-phong:100, asked for 30 %")))
      << met.out;
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"map_normal.png", "map_albedo.png", "map.ndf.exr", "map.json"}));
  const nlohmann::json report = nlohmann::json::parse(read_bytes(path("map.json")));
  bool found = false;
  for (const nlohmann::json& one : report["error"]) {
    if (!one["brdf"].get<std::string>().starts_with("blinn-phong:100")) continue;
    found = found || one["relative_l1"].get<double>() + one["confidence_95"].get<double>() <= 0.3;
  }
  EXPECT_TRUE(found) << report["error"];
  // The report lists the errors at footprints that were not used to choose the settings, and the worst of these errors.
  std::smatch judged;
  ASSERT_TRUE(std::regex_search(
      met.out, judged,
      std::regex("chosen: [^:]*: (\\S+) \\+- (\\S+) %[^]*measured at footprints that were not used to choose the "
                 "settings; the error at the footprints that were used is (\\S+) \\+- [^]*95 % of pixels have errors "
                 "of at most \\S+ %; the worst pixels cover \\d+ to \\d+ texels and have an error of \\S+ %")))
      << met.out;
  EXPECT_LE(std::stod(judged[1]) + std::stod(judged[2]), 30.0);
  EXPECT_NE(judged[1], judged[3]) << "the same footprints again";
  bool has_chosen_by = false;
  for (const nlohmann::json& one : report["error"])
    has_chosen_by = has_chosen_by || std::abs(100.0 * one["relative_l1"].get<double>() - std::stod(judged[3])) < 0.006;
  EXPECT_TRUE(has_chosen_by) << met.out << report["error"];
  EXPECT_TRUE(contains(report["choice"], "chosen")) << report["choice"];
  // The file states the settings like any other file: a second bake with these settings gives the same texels.
  const std::string options = std::regex_replace(met.out, std::regex("[^]*chosen: (.*?): [0-9][^]*"), "$1");
  std::vector<std::string> again = {"bake", path("map_normal.png"), "-o", path("again.ndf.exr"), "--green", "up"};
  std::stringstream words(options);
  for (std::string word; words >> word;) again.push_back(word);
  ASSERT_EQ(multum(again).exit_code, 0) << options;
  EXPECT_EQ(read_baked_header(path("again.ndf.exr")).provenance.content_hash,
            read_baked_header(path("map.ndf.exr")).provenance.content_hash);
}

TEST_F(TargetCommandTest, RefusesWhatNothingReaches) {
  const std::vector<std::string> impossible = {"--target-error", "0.00001", "--brdf",
                                               "blinn-phong:70", "--ndf",   "moments"};
  const ProgramResult refused = bake(impossible);
  expect_refusal(refused, kVerification,
                 {"map_normal.png: ", "no settings", "best reached", "--ndf moments: ", "shaded as", "--best-effort"});
  EXPECT_FALSE(is_written());
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"map_normal.png", "map_albedo.png"}));

  std::vector<std::string> best_effort = impossible;
  best_effort.push_back("--best-effort");
  const ProgramResult written = bake(best_effort);
  expect_refusal(written, kVerification, {"map_normal.png: ", "no settings", "were used"});
  EXPECT_EQ(multum({"verify", path("map.ndf.exr")}).exit_code, 0);
  // An exponent that is not one of the usual ones is not stored in the file.
  EXPECT_FALSE(contains(multum({"info", path("map.ndf.exr")}).out, "blinn-phong:70"));
}

TEST_F(TargetCommandTest, LeavesWhatWasChosenForTheSame) {
  const std::vector<std::string> wide = {"--target-error", "0.5", "--ndf", "vmf"};
  ASSERT_EQ(bake(wide).exit_code, 0);
  const auto is_unchanged = [](const ProgramResult& result) { return contains(result.out, "map.ndf.exr: unchanged"); };
  EXPECT_TRUE(is_unchanged(bake(wide)));
  EXPECT_FALSE(is_unchanged(bake({"--target-error", "0.5", "--ndf", "vmf", "--force"})));
  EXPECT_FALSE(is_unchanged(bake({"--target-error", "0.5", "--ndf", "vmf", "--align", "0.2"}))) << "another prior";
  ASSERT_EQ(bake({"--target-error", "0.5", "--ndf", "vmf", "--brdf", "lambert"}).exit_code, 0);
  EXPECT_FALSE(is_unchanged(bake(wide))) << "another BRDF";
  // A second run does not treat a file that misses its target as up to date.
  const std::vector<std::string> missed = {"--target-error", "0.00001", "--ndf", "moments", "--best-effort"};
  EXPECT_EQ(bake(missed).exit_code, 5);
  EXPECT_EQ(bake(missed).exit_code, 5);
}

TEST_F(TargetCommandTest, CountsForTheBrdfThatIsNamed) {
  const ProgramResult met = bake({"--target-error", "0.2", "--brdf", "ggx:0.5", "-v"});
  ASSERT_EQ(met.exit_code, 0) << met.err;
  EXPECT_TRUE(std::regex_search(met.out, std::regex("chosen: .* % for ggx:0.5, asked for 20 %"))) << met.out;
  EXPECT_TRUE(std::regex_search(met.out, std::regex("\n  ggx:0.5 +[0-9.]+ \\+- [0-9.]+ %"))) << met.out;
  const ProgramResult missing = bake({"--target-error", "0.2", "--brdf", path("none.brdf")});
  expect_refusal(missing, kUsage, {"none.brdf'", "lambert", "blinn-phong:S"});
}

TEST_F(TargetCommandTest, KeepsToABudget) {
  const ProgramResult plenty =
      bake({"--budget-ms", "1e6", "--ndf", "sh", "--brdf", "lambert", "--report", path("r.json")});
  ASSERT_EQ(plenty.exit_code, 0) << plenty.err;
  EXPECT_TRUE(contains(plenty.out, "chosen: --ndf sh --sh-order")) << plenty.out;
  const ProgramResult none = bake({"--budget-ms", "0.001", "--ndf", "moments"});
  expect_refusal(none, kVerification, {"map_normal.png: ", "asked for 0"});
}

TEST_F(TargetCommandTest, RefusesWhatDoesNotGoTogether) {
  for (const std::vector<std::string>& options :
       std::vector<std::vector<std::string>>{{"--target-error", "0"},
                                             {"--target-error", "nan"},
                                             {"--budget-ms", "-1"},
                                             {"--target-error", "0.1", "--budget-ms", "5"},
                                             {"--target-error", "0.1", "--lobes", "3"},
                                             {"--target-error", "0.1", "--no-measure"},
                                             {"--target-error", "0.1", "--brdf", "phong:3"},
                                             {"--target-error", "0.1", "--brdf", "ggx:0.4", "--ndf", "gmm"},
                                             {"--budget-ms", "100", "--resume"},
                                             {"--brdf", "lambert"},
                                             {"--best-effort"}}) {
    const ProgramResult refused = bake(options);
    EXPECT_EQ(refused.exit_code, 2) << options.front() << "\n" << refused.err;
    EXPECT_FALSE(is_written());
  }
}

// The error appears in the printed text, in the report and in the header of the file. Levels of small maps are measured
// completely, without an interval.
TEST_F(TargetCommandTest, PlainBakesSayTheirErrorWithItsInterval) {
  for (const int size : {32, 512}) {
    make_map("map", size);
    const ProgramResult plain =
        bake({"--lobes", "1", "--passes", "1", "--no-start-search", "--force", "--report", path("map.json"), "-v"});
    ASSERT_EQ(plain.exit_code, 0) << plain.err;
    const bool is_sampled = size > 32;
    const std::string interval = is_sampled ? " \\+- [0-9.]+" : "";
    const std::regex line(
        "error of pixels [^\n]*\n  blinn-phong:20 +[0-9.]+ \\+- [0-9.]+ %; 95 % of pixels within [0-9.]+ %; "
        "worst: [0-9.]+ % for pixels that cover \\d+ to \\d+ texels\n");
    std::smatch said, stated_line;
    EXPECT_TRUE(std::regex_search(plain.out, said, line)) << plain.out;
    const std::string info = multum({"info", path("map.ndf.exr")}).out;
    EXPECT_TRUE(std::regex_search(info, stated_line, line)) << info;
    EXPECT_EQ(said.str(), stated_line.str());
    const std::string table = "\n      0 +" + std::string(is_sampled ? "sampled" : "all") + " +[0-9.]+" + interval +
                              " \\| [0-9.]+" + interval + " ";
    EXPECT_TRUE(std::regex_search(plain.out, std::regex(table))) << plain.out;
    EXPECT_TRUE(std::regex_search(multum({"info", path("map.ndf.exr")}).out, std::regex(table)));
    const nlohmann::json report = nlohmann::json::parse(read_bytes(path("map.json")));
    const std::string stated = read_baked_header(path("map.ndf.exr")).provenance.measured_error;
    const nlohmann::json header = nlohmann::json::parse(stated);
    const std::size_t pixels = report["error"].size();
    ASSERT_EQ(pixels, 4u) << "Blinn-Phong of three exponents, and Lambert";
    for (std::size_t i = 0; i < pixels; ++i) {
      EXPECT_EQ(header[i][1], "pixels");
      EXPECT_NEAR(header[i][3].get<double>(), report["error"][i]["relative_l1"].get<double>(), 1e-6);
      EXPECT_NEAR(header[i][5].get<double>(), report["error"][i]["percentile_95"].get<double>(), 1e-6);
      int footprints = 0;
      for (int k = 0; k < footprint_octave_count(size, size); ++k) footprints += footprint_count(k, size, size, 256);
      EXPECT_EQ(report["error"][i]["footprints"], footprints);
    }
    ASSERT_EQ(header.size(), pixels + report["measured_error"].size());
    for (std::size_t i = pixels; i < header.size(); ++i) {
      const nlohmann::json& row = report["measured_error"][i - pixels];
      const bool all_texels = (size >> row["level"].get<int>()) <= 32;  // at most 2048 texels
      EXPECT_EQ(row["all_texels"], all_texels) << row;
      EXPECT_EQ(row["confidence_95"] == 0.0, all_texels) << row;
      EXPECT_NEAR(header[i][4].get<double>(), row["confidence_95"].get<double>(), 1e-6) << row;
      EXPECT_EQ(header[i][4] == 0, all_texels) << row;
    }
  }
}

}  // namespace
}  // namespace multum::testing
