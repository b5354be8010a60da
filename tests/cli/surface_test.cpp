// SPDX-License-Identifier: Apache-2.0
// Bakes of the surface between texels, as renderers show it from near: `multum bake --surface interpolated`.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "host/asset/lobes/movmf_mipmap.h"
#include "host/image/files/png_writer.h"
#include "tests/cli/program.h"

namespace multum {
namespace {

using testing::CliTest;
using testing::expect_refusal;
using testing::ProgramResult;

constexpr int kSize = 128;

class SurfaceCommandTest : public CliTest {
 protected:
  /// White noise: no two texels have to do with one another, where the surface between them is smoothest.
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
  /// Of the coarsest texel, 1 - |mean normal|.
  double spread(const std::string& name) {
    const MovmfMipmap map = read_movmf_mipmap(path(name));
    glm::vec4 sum(0.0f);
    for (const auto& lobes : map.levels.back().lobes) sum += lobes[0];
    return 1.0 - static_cast<double>(glm::length(glm::vec3(sum)) / sum.w);
  }
};

// Two points of three in each direction are independent halves of neighbours: the variance is (2/3)^2 of the texels'.
TEST_F(SurfaceCommandTest, OfWhiteNoiseTheVarianceIsFourNinths) {
  write_noise(0.1f);
  bake("texels.ndf.exr", {"--first-level", "1", "--no-measure"});
  bake("surface.ndf.exr", {"--surface", "interpolated", "--no-measure"});
  EXPECT_NEAR(spread("surface.ndf.exr") / spread("texels.ndf.exr"), 4.0 / 9.0, 0.02);
  const MovmfMipmap map = read_movmf_mipmap(path("surface.ndf.exr"));
  EXPECT_EQ(map.header.first_level, 1) << "level 0 is the normal map's";
  const nlohmann::json settings = nlohmann::json::parse(map.header.provenance.settings);
  EXPECT_EQ(settings.value("surface", ""), "interpolated");
}

// From afar; nearer, both have the normal map.
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

TEST_F(SurfaceCommandTest, SharesAndThreadsAndOtherNdfsAreOfTheSameSurface) {
  write_noise(0.3f);
  bake("one.ndf.exr", {"--surface", "interpolated"});
  for (const char* part : {"0/2", "1/2", "2/2"}) bake("two.ndf.exr", {"--surface", "interpolated", "--shard", part});
  bake("two.ndf.exr", {"--surface", "interpolated", "--merge", "2"});
  EXPECT_TRUE(testing::read_bytes(path("one.ndf.exr")) == testing::read_bytes(path("two.ndf.exr")));
  const ProgramResult other =
      multum({"bake", path("n.png"), "-o", path("three.ndf.exr"), "--bumpformat", "normal", "--shard", "1/2"});
  expect_refusal(other, testing::kEnvironment, {"three.ndf.exr.shard-0-of-2"});
  for (const char* ndf : {"moments", "sh", "gmm"})
    bake(std::string(ndf) + ".ndf.exr", {"--surface", "interpolated", "--ndf", ndf});
  for (const char* name : {"one", "moments", "sh", "gmm"}) {
    const ProgramResult verify = multum({"verify", path(std::string(name) + ".ndf.exr")});
    EXPECT_EQ(verify.exit_code, 0) << name << verify.out << verify.err;
  }
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
  // A bake of the texels is not taken for one of the surface.
  bake("map.ndf.exr", {"--first-level", "1"});
  const std::string texels = testing::read_bytes(path("map.ndf.exr"));
  bake("map.ndf.exr", {"--first-level", "1", "--surface", "interpolated"});
  EXPECT_TRUE(testing::read_bytes(path("map.ndf.exr")) != texels);
}

}  // namespace
}  // namespace multum
