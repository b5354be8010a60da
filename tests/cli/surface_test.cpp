// SPDX-License-Identifier: Apache-2.0
// Tests bakes of the surface between texels, which renderers show when they magnify: `multum bake --surface
// interpolated`.
#include <OpenImageIO/imagebuf.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/image/files/png_writer.h"
#include "host/foundation/base/files/atomic_file.h"
#include "tests/cli/program.h"

namespace multum {
namespace {

using testing::CliTest;
using testing::expect_refusal;
using testing::ProgramResult;

constexpr int kSize = 128;

class SurfaceCommandTest : public CliTest {
 protected:
  /// In white noise, texels are independent of each other, so the surface between them is much smoother than the
  /// texels.
  void write_noise(float slope) const {
    std::mt19937 random(11);
    std::normal_distribution<float> slopes(0.0f, slope);
    std::vector<std::uint16_t> codes;
    for (int i = 0; i < kSize * kSize; ++i) {
      const float x = slopes(random), y = slopes(random);
      const glm::vec3 n = glm::normalize(glm::vec3(x, y, 1.0f));
      for (int c = 0; c < 3; ++c) codes.push_back(static_cast<std::uint16_t>(std::lround((n[c] + 1.0f) * 32767.5f)));
    }
    write_png16(path("n.png"), kSize, kSize, codes, "Linear");
  }
  void bake(const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"bake", path("n.png"), "-o", path(name), "--bumpformat", "normal", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = multum(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  /// Returns 1 - |mean normal| of the coarsest texel.
  double spread(const std::string& name) {
    const MovmfMipmap map = read_movmf_mipmap(path(name));
    glm::vec4 sum(0.0f);
    for (const auto& lobes : map.levels.back().lobes) sum += lobes[0];
    return 1.0 - static_cast<double>(glm::length(glm::vec3(sum)) / sum.w);
  }
};

// In each direction, two of three points are means of two independent neighbours, which halves their variance. In both
// directions together, the variance is (2/3)^2 of the texels' variance.
TEST_F(SurfaceCommandTest, OfWhiteNoiseTheVarianceIsFourNinths) {
  write_noise(0.1f);
  bake("texels.ndf.exr", {"--first-level", "1", "--no-measure"});
  bake("surface.ndf.exr", {"--surface", "interpolated", "--no-measure"});
  EXPECT_NEAR(spread("surface.ndf.exr") / spread("texels.ndf.exr"), 4.0 / 9.0, 0.02);
  const MovmfMipmap map = read_movmf_mipmap(path("surface.ndf.exr"));
  EXPECT_EQ(map.header.first_level, 1) << "level 0 comes from the normal map";
  const nlohmann::json settings = nlohmann::json::parse(map.header.provenance.settings);
  EXPECT_EQ(settings.value("surface", ""), "interpolated");
}

// Compares pictures that are seen from a distance. From near, both bakes use the normal map.
TEST_F(SurfaceCommandTest, PicturesAreNearerWhatIsInterpolated) {
  write_noise(0.3f);
  bake("texels.ndf.exr", {"--first-level", "1", "--no-measure"});
  bake("surface.ndf.exr", {"--surface", "interpolated", "--no-measure"});
  const auto error = [&](const std::string& name, const std::string& repeat) {
    const ProgramResult drawn = testing::run_program({std::string(MULTUM_BIN_DIR) + "/multum-view",
                                                      path(name),
                                                      "--source",
                                                      path("n.png"),
                                                      "-o",
                                                      path("out.png"),
                                                      "--compare",
                                                      "reference",
                                                      "--reference-texels",
                                                      "interpolated",
                                                      "--samples",
                                                      "64",
                                                      "--camera",
                                                      "0,30,60,0,30,0,40",
                                                      "--size",
                                                      "96x96",
                                                      "--evaluations",
                                                      "0",
                                                      "--repeat",
                                                      repeat,
                                                      "--brdf",
                                                      "blinn-phong:50",
                                                      "--report",
                                                      path("r.json"),
                                                      "--context",
                                                      "osmesa"});
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    return nlohmann::json::parse(testing::read_bytes(path("r.json")))["pictures"][1]["relative_l1"].get<double>();
  };
  for (const std::string repeat : {"4", "8"})
    EXPECT_LT(error("surface.ndf.exr", repeat), 0.6 * error("texels.ndf.exr", repeat)) << repeat;
}

TEST_F(SurfaceCommandTest, SharesAndOtherNdfsAreOfTheSameSurface) {
  write_noise(0.3f);
  bake("one.ndf.exr", {"--surface", "interpolated"});
  for (const char* part : {"0/2", "1/2", "2/2"}) bake("two.ndf.exr", {"--surface", "interpolated", "--shard", part});
  const ProgramResult other =
      multum({"bake", path("n.png"), "-o", path("two.ndf.exr"), "--bumpformat", "normal", "--merge", "2"});
  expect_refusal(other, testing::kEnvironment, {"two.ndf.exr.shard-0-of-2", "other settings"});
  bake("two.ndf.exr", {"--surface", "interpolated", "--merge", "2"});
  EXPECT_TRUE(testing::read_bytes(path("one.ndf.exr")) == testing::read_bytes(path("two.ndf.exr")));
  for (const char* ndf : {"moments", "sh", "gmm"})
    bake(std::string(ndf) + ".ndf.exr", {"--surface", "interpolated", "--ndf", ndf});
  for (const char* name : {"one", "moments", "sh", "gmm"}) {
    const ProgramResult verify = multum({"verify", path(std::string(name) + ".ndf.exr")});
    EXPECT_EQ(verify.exit_code, 0) << name << verify.out << verify.err;
  }
}

// Level 0 is the map itself. Coarser levels look smoother, because interpolated normals vary less.
TEST_F(SurfaceCommandTest, ExportedLobesAreOfTheSurfaceFromLevel1On) {
  write_noise(0.3f);
  const auto roughness = [&](const std::string& surface, const char* level) {
    const std::string folder = path(surface);
    if (!std::filesystem::exists(folder)) {
      const ProgramResult result = multum({"export", path("n.png"), "-o", folder, "--bumpformat", "normal", "--surface",
                                           surface, "--base-roughness", "0.2", "--report", folder + ".json"});
      EXPECT_EQ(result.exit_code, 0) << result.err;
      EXPECT_EQ(nlohmann::json::parse(testing::read_bytes(folder + ".json"))["surface"], surface);
    }
    OIIO::ImageBuf orm(folder + "/orm_" + level + ".png");
    OIIO::ImageSpec spec = orm.spec();
    double sum = 0.0;
    for (int y = 0; y < spec.height; ++y)
      for (int x = 0; x < spec.width; ++x) sum += static_cast<double>(orm.getchannel(x, y, 0, 1));
    return sum / (spec.width * spec.height);
  };
  EXPECT_NEAR(roughness("texels", "00"), 0.2, 0.003);
  EXPECT_NEAR(roughness("interpolated", "00"), 0.2, 0.003);
  for (const char* name : {"normal_00.png", "orm_00.png"})
    EXPECT_TRUE(testing::read_bytes(path("texels/") + name) == testing::read_bytes(path("interpolated/") + name));
  for (const char* level : {"01", "03", "05"})
    EXPECT_LT(roughness("interpolated", level), 0.88 * roughness("texels", level)) << level;
}

TEST_F(SurfaceCommandTest, TexelsAndPointsAreNotMixed) {
  write_noise(0.3f);
  const auto refused = [&](const std::vector<std::string>& more, const std::vector<std::string>& parts) {
    std::vector<std::string> words = {"bake", path("n.png"), "-o", path("none.ndf.exr")};
    words.insert(words.end(), more.begin(), more.end());
    expect_refusal(multum(words), testing::kUsage, parts);
  };
  refused({"--surface", "interpolated", "--first-level", "0"},
          {"--first-level is 0", "--surface interpolated", "1 or more"});
  refused({"--surface", "smooth"}, {"--surface", "smooth", "texels", "interpolated"});
  EXPECT_EQ(folder_.names(), (testing::Names{"n.png"}));
  write_text_file(
      path("maps.toml"),
      "[[map]]\ninput = \"n.png\"\noutput = \"none.ndf.exr\"\nsurface = \"interpolated\"\nfirst_level = 0\n");
  expect_refusal(multum({"bake", "--manifest", path("maps.toml")}), testing::kInput,
                 {"maps.toml:5", "first_level", "1 or more"});
  std::filesystem::remove(path("maps.toml"));
  // A bake of the texels does not count as a bake of the surface.
  bake("map.ndf.exr", {"--first-level", "1"});
  const std::string texels = testing::read_bytes(path("map.ndf.exr"));
  bake("map.ndf.exr", {"--first-level", "1", "--surface", "interpolated"});
  EXPECT_TRUE(testing::read_bytes(path("map.ndf.exr")) != texels);
  bake("old.ndf.exr", {"--first-level", "1"});
  expect_refusal(multum({"bake", path("n.png"), "-o", path("new.ndf.exr"), "--bumpformat", "normal", "--surface",
                         "interpolated", "--onto", path("old.ndf.exr"), "--region", "8,8,16,16"}),
                 testing::kInput, {"old.ndf.exr", "surface of texels", "expected interpolated"});
  expect_refusal(multum({"bake", path("n.png"), "-o", path("new.ndf.exr"), "--bumpformat", "normal", "--surface",
                         "interpolated", "--onto", path("map.ndf.exr"), "--region", "0,8,16,16"}),
                 testing::kUsage, {"--region 0,8,16,16", "repeats", "--surface"});
  expect_refusal(
      multum({"export", path("n.png"), "-o", path("out"), "--bumpformat", "normal", "--beside", path("map.ndf.exr")}),
      testing::kInput, {"map.ndf.exr", "--surface interpolated", "expected texels"});
}

// A manifest's bound is measured again at the same points; levels that the normal map provides are not measured.
TEST_F(SurfaceCommandTest, ItsErrorIsMeasuredFromTheFirstStoredLevelOn) {
  write_noise(0.3f);
  write_text_file(path("maps.toml"),
                  "[[map]]\ninput = \"n.png\"\noutput = \"map.ndf.exr\"\nbumpformat = \"normal\"\nsurface = "
                  "\"interpolated\"\nerror_max = 0.9\n");
  for (const bool checks : {false, true}) {
    std::vector<std::string> words = {"bake", "--manifest", path("maps.toml")};
    if (checks) words.push_back("--check");
    const ProgramResult result = multum(words);
    EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  }
  const ProgramResult one = multum({"bake", path("n.png"), "-o", path("one.ndf.exr"), "--bumpformat", "normal",
                                    "--surface", "interpolated", "--report", path("one.json")});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  EXPECT_EQ(one.out.find("as this table does"), std::string::npos) << one.out;
  const nlohmann::json report = nlohmann::json::parse(testing::read_bytes(path("one.json")));
  ASSERT_FALSE(report.at("measured_error").empty());
  for (const nlohmann::json& row : report["measured_error"]) EXPECT_GE(row["level"].get<int>(), 1) << row;
}

// Colours are sampled at the same points as normals. Half of the texels are red and lean left, and the other half are
// blue and lean right.
TEST_F(SurfaceCommandTest, ColoursAreTakenAtTheSamePoints) {
  std::vector<std::uint16_t> normals, colours;
  for (int i = 0; i < kSize * kSize; ++i) {
    const bool leans_left = i / 2 % 2 == 0;
    const glm::vec3 n = glm::normalize(glm::vec3(leans_left ? -0.3f : 0.3f, 0.0f, 1.0f));
    for (int c = 0; c < 3; ++c) normals.push_back(static_cast<std::uint16_t>(std::lround((n[c] + 1.0f) * 32767.5f)));
    for (const bool is_on : {leans_left, false, !leans_left}) colours.push_back(is_on ? 65535 : 0);
  }
  write_png16(path("n.png"), kSize, kSize, normals, "Linear");
  write_png16(path("c.png"), kSize, kSize, colours, "Linear");
  bake("map.ndf.exr", {"--surface", "interpolated", "--albedo", path("c.png"), "--no-measure"});
  const MovmfMipmap map = read_movmf_mipmap(path("map.ndf.exr"));
  const MovmfLevel& level = map.levels[3];
  double sum = 0.0, mean = 0.0, texels = 0.0;
  for (std::size_t j = 0; j < level.lobes.size(); ++j)
    for (std::size_t i = 0; i < level.lobes[j].size(); ++i) {
      const glm::vec4& lobe = level.lobes[j][i];
      const glm::vec3& colour = level.colours[j][i];  // the colour times the amplitude
      if (lobe.w < 1e-3f) continue;
      sum += static_cast<double>(lobe.x / lobe.w * (colour.z - colour.x));
      mean += static_cast<double>(colour.x + colour.z), texels += static_cast<double>(lobe.w);
    }
  EXPECT_NEAR(mean / texels, 1.0, 0.01) << "the sum of red and blue must stay";
  EXPECT_GT(sum / texels, 0.17) << "facets that lean right are blue";
  EXPECT_LT(sum / texels, 0.21) << "the texels' own colours differ more";
}

}  // namespace
}  // namespace multum
