// SPDX-License-Identifier: Apache-2.0
// Tests multum check: verdicts of maps that gain and of maps that do not, folders, exit codes, and the sentence that
// ends a bake and an export.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class CheckCommandTest : public CliTest {
 protected:
  void write_flat(const std::string& name) const {
    TestImage image{64, 64, 3};
    for (int i = 0; i < 64 * 64; ++i)
      for (const float value : {0.5f, 0.5f, 1.0f}) image.values.push_back(value);
    write_test_image(path(name), image);
  }
  // Writes hammered_normal.png, hammered_albedo.png and hammered_orm.png.
  void write_hammered() const { ASSERT_EQ(multum({"testmap", path("hammered"), "--size", "512"}).exit_code, 0); }
  nlohmann::json checked(std::vector<std::string> more) const {
    more.insert(more.begin(), "check");
    more.emplace_back("--json");
    const ProgramResult result = multum(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out)["maps"];
  }
};

TEST_F(CheckCommandTest, AFlatMapKeepsItsMips) {
  write_flat("flat.png");
  const std::vector<std::string> words = {"check", path("flat.png"), "--bumpformat", "normal", "--green", "up"};
  const ProgramResult result = multum(words);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("flat.png: flat: keep your mips (their error is at most 0."), std::string::npos)
      << result.out;
  std::vector<std::string> limited = words;
  limited.insert(limited.end(), {"--fail-below", "1"});
  expect_refusal(multum(limited), kVerification,
                 {"flat.png", "found a gain of 0.", "expected at least 1.0", "--fail-below"});
}

TEST_F(CheckCommandTest, AHammeredMetalGains) {
  write_hammered();
  const auto map = checked({path("hammered_normal.png"), "--metal"})[0];
  EXPECT_EQ(map["advice"], "lobes") << map["sentence"];
  EXPECT_GT(map["gain"], 3.0);
  EXPECT_EQ(map["errors"].size(), 2u * (6u + 3u + 3u));
  for (const auto& error : map["errors"])
    if (error["distance"] >= 5.0 && error["roughness"] <= 0.3) {
      EXPECT_LT(error["lobes"], error["plain"]) << error;
      EXPECT_LT(error["noise"], error["plain"]) << error;
    }
  const ProgramResult passed = multum({"check", path("hammered_normal.png"), "--metal", "--fail-below", "3"});
  EXPECT_EQ(passed.exit_code, 0) << passed.err;
  EXPECT_NE(passed.out.find("lobes are worth it"), std::string::npos) << passed.out;
}

TEST_F(CheckCommandTest, TheSameMapGivesTheSameVerdict) {
  write_hammered();
  EXPECT_EQ(checked({path("hammered_normal.png"), "--threads", "1"}), checked({path("hammered_normal.png")}));
}

TEST_F(CheckCommandTest, SmallerTilesAreLikeFartherViews) {
  write_hammered();
  const auto at = [&](const char* tile, double distance) {
    const nlohmann::json maps = checked({path("hammered_normal.png"), "--tile-size", tile});
    for (const auto& error : maps[0]["errors"])
      if (error["distance"] == distance && error["roughness"] == 0.3 && error["light"] == "sun")
        return error["plain"].get<double>();
    return -1.0;
  };
  const double far = at("1", 10.0);
  EXPECT_GT(far, 0.0);
  EXPECT_NEAR(far, at("0.5", 5.0), 0.1 * far) << "only the choice of lights differs";
}

TEST_F(CheckCommandTest, AFolderHasOneVerdictPerMap) {
  write_flat("flat_normal.png");
  write_hammered();
  write_test_image(path("notes_roughness.png"), TestImage{8, 8, 1, std::vector<float>(64, 0.5f)});
  std::vector<std::string> names;
  for (const auto& map : checked({path("")}))
    if (map.contains("advice")) names.push_back(std::filesystem::path(map["name"].get<std::string>()).filename());
  EXPECT_EQ(names, (std::vector<std::string>{"flat_normal.png", "hammered_normal.png"}));
  expect_refusal(multum({"check", path("missing.png")}), kInput, {"missing.png"});
  std::filesystem::create_directory(path("empty"));
  expect_refusal(multum({"check", path("empty")}), kInput, {"empty", "no images or models"});
}

TEST_F(CheckCommandTest, ABakeAndAnExportEndWithTheSentence) {
  write_hammered();
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"bake", path("hammered_normal.png"), "-o", path("h.ndf.exr")},
        std::vector<std::string>{"export", path("hammered_normal.png"), "-o", path("out"), "--roughness",
                                 path("hammered_orm.png"), "--metalness", path("hammered_orm.png")}}) {
    const ProgramResult result = multum(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::string last = result.out.substr(result.out.rfind('\n', result.out.size() - 2) + 1);
    EXPECT_NE(last.find(": plain mips "), std::string::npos) << result.out;
    EXPECT_NE(last.find(" lobes "), std::string::npos) << result.out;
    EXPECT_EQ(last.find("roughness") == std::string::npos, words[0] == "export") << last;
  }
  const ProgramResult unmeasured =
      multum({"bake", path("hammered_normal.png"), "-o", path("n.ndf.exr"), "--no-measure"});
  EXPECT_EQ(unmeasured.out.find("plain mips"), std::string::npos) << unmeasured.out;
}

TEST_F(CheckCommandTest, EachMapOfAManifestEndsWithTheSentence) {
  write_hammered();
  const std::string map = "\"hammered_normal.png\"\n";
  write_bytes(path("bakes.toml"), "[[map]]\ninput = " + map + "output = \"m.ndf.exr\"\n");
  write_bytes(path("exports.toml"), "[[map]]\ninput = " + map + "output = \"m.ktx2\"\n");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"bake", "--manifest", path("bakes.toml")},
        std::vector<std::string>{"export", "--manifest", path("exports.toml")}}) {
    SCOPED_TRACE(words[0] + " " + words[1]);
    const ProgramResult result = multum(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.out.find(": plain mips "), std::string::npos) << result.out;
    std::vector<std::string> as_json = words;
    as_json.insert(as_json.end(), {"--json", "--force"});
    const ProgramResult json = multum(as_json);
    ASSERT_EQ(json.exit_code, 0) << json.err;
    const nlohmann::json made = nlohmann::json::parse(json.out)["maps"][0];
    const std::string sentence = made["report"]["gain"]["sentence"];
    EXPECT_NE(sentence.find("plain mips "), std::string::npos) << sentence;
  }
}

}  // namespace
}  // namespace multum::testing
