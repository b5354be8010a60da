// SPDX-License-Identifier: Apache-2.0
// Tests multum export --form and --for: the values of the levels, the printed lines, and the refusals.
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/cli/exports/export_test.h"

namespace multum::testing {
namespace {

class ExportFormsTest : public ExportTest {
 protected:
  static TestImage rough_image(int width, int height) {
    TestImage image{width, height, 1};
    for (int i = 0; i < width * height; ++i) image.values.push_back(i % 3 == 0 ? 0.2f : 0.35f);
    return image;
  }
};

TEST_F(ExportFormsTest, AveragesAreMeansWithFittedRoughness) {
  write("map.png", normal_image(32, 32));
  const auto exported = [&](const std::string& form) {
    const ProgramResult result = run({"--format", "exr", "--no-measure", "--form", form});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return std::make_pair(level("normal_02.exr"), level("orm_02.exr"));
  };
  const auto [normals, orm] = exported("averages");
  const Picture finest = level("normal_00.exr");
  for (int c = 0; c < 3; ++c) {
    float mean = 0.0f;
    for (int i = 0; i < 16; ++i) mean += finest.at(4 + i % 4, 8 + i / 4, c) / 16.0f;
    EXPECT_NEAR(normals.at(1, 2, c), mean, 2e-3f) << "as long as the mean is";
  }
  const auto [fitted, fitted_orm] = exported("one-lobe");
  EXPECT_EQ(orm.at(1, 2, 1), fitted_orm.at(1, 2, 1));
  EXPECT_NE(normals.at(1, 2, 2), fitted.at(1, 2, 2));
}

TEST_F(ExportFormsTest, PicturesOfSimpleShapesChooseTheForm) {
  write("map.png", normal_image(96, 64));
  write("rough.png", rough_image(96, 64));
  const std::vector<std::string> more = {
      "--form", "auto",         "--for",       "godot",           "--format", "png",          "--sides",
      "any",    "--no-measure", "--roughness", path("rough.png"), "--report", path("r.json"), "-v"};
  const ProgramResult result = run(more);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find(" texels per pixel: plain mips "), std::string::npos) << result.out;
  EXPECT_NE(result.out.find(" %, export "), std::string::npos) << result.out;
  const auto report = nlohmann::json::parse(read_bytes(path("r.json")));
  EXPECT_EQ(report["form"], "auto");
  EXPECT_EQ(report["for"], "godot");
  const auto& form = report["forms"][0];
  const std::size_t views = form["distances"].size();
  EXPECT_EQ(form["shapes"].size(), views);
  ASSERT_GE(views, 6u);
  for (std::size_t v = 0; v < views; ++v)
    EXPECT_LE(form["errors"]["chosen"][v], form["errors"]["one_lobe"][v].get<double>() + 0.1);
  ASSERT_EQ(form["levels"].size(), 7u);
  EXPECT_EQ(form["levels"][0]["fitted_roughness"], 0.0);
  // The levels hold the chosen roughness, which is between the map's own and the fitted one.
  std::vector<float> chosen;
  for (int l = 0; l < 7; ++l) chosen.push_back(level("orm_0" + std::to_string(l) + ".png").at(0, 0, 1));
  ASSERT_EQ(run({"--no-measure", "--roughness", path("rough.png")}).exit_code, 0);
  for (int l = 0; l < 7; ++l) {
    const float fitted = level("orm_0" + std::to_string(l) + ".png").at(0, 0, 1);
    const double share = form["levels"][l]["fitted_roughness"];
    EXPECT_LE(chosen[static_cast<std::size_t>(l)], fitted + 1.0f / 255.0f) << l;
    if (share == 1.0 || l == 0) {
      EXPECT_EQ(chosen[static_cast<std::size_t>(l)], fitted) << l;
    }
  }
}

TEST_F(ExportFormsTest, RefusesFormsThatItHasNot) {
  write("map.png", normal_image(8, 8));
  expect_refused({"--form", "best"}, 2, {"--form", "auto", "averages", "one-lobe"});
  expect_refused({"--form", "auto", "--for", "quake"}, 2, {"--for", "three", "babylon", "filament", "unreal"});
  expect_refused({"--form", "auto", "--anisotropy"}, 2, {"--form", "found auto", "expected one-lobe"});
  EXPECT_EQ(run({"--form", "one-lobe", "--anisotropy", "--no-measure"}).exit_code, 0);
}

TEST_F(ExportFormsTest, IsTheSameForAnyMemoryAndThreads) {
  write("map.png", normal_image(150, 90));
  write("rough.png", rough_image(150, 90));
  const auto files = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--form", "auto", "--no-measure", "--roughness", path("rough.png")});
    const ProgramResult result = run(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::map<std::string, std::string> bytes;
    for (const auto& entry : std::filesystem::directory_iterator(path("out")))
      bytes[entry.path().filename().string()] = read_bytes(entry.path().string());
    std::filesystem::remove_all(path("out"));
    return bytes;
  };
  const auto plain = files({});
  EXPECT_EQ(plain.size(), 16u);
  EXPECT_EQ(files({"--memory", "200K", "--threads", "1"}), plain);
}

}  // namespace
}  // namespace multum::testing
