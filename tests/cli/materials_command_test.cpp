// SPDX-License-Identifier: Apache-2.0
// Tests multum bake --roughness and --weights: the contents of the file, and whether changed inputs are noticed in
// manifests and for every representation.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class MaterialsCommandTest : public CliTest {
 protected:
  void SetUp() override {
    make_map("map", 64);
    // The first file has glTF's order of channels (occlusion, roughness, metalness). The second file has the weights of
    // four BRDFs.
    write_waves("orm.png", 3, 0.5);
    write_waves("weights.png", 4, 1.0);
  }
  void write_waves(const std::string& name, int channels, double size) const {
    TestImage image{.width = 64, .height = 64, .channels = channels, .type = OIIO::TypeDesc::UINT8};
    for (int i = 0; i < 64 * 64; ++i)
      for (int c = 0; c < channels; ++c)
        image.values.push_back(static_cast<float>(0.2 + 0.5 * size * (0.5 + 0.5 * std::sin(0.1 * (c + 1) * (i % 64)))));
    if (channels == 4) image.alpha_channel = 3;
    write_test_image(path(name), image);
  }
  // Writes a roughness map that is 0 except for one texel.
  void write_rough_texel(float value) const {
    TestImage image{.width = 64, .height = 64, .channels = 1, .type = OIIO::TypeDesc::FLOAT};
    image.values.assign(64 * 64, 0.0f);
    image.values[64 + 5] = value;
    write_test_image(path("rough.exr"), image);
  }
  static void append_options_of(const std::string& ndf, std::vector<std::string>& options) {
    if (ndf == "vmf" || ndf == "gmm") options.insert(options.end(), {"--no-start-search", "--lobes", "2"});
    if (ndf == "sh") options.insert(options.end(), {"--sh-order", "2"});
  }
  ProgramResult bake(const std::string& output, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"bake", path("map_normal.png"), "-o", path(output)});
    return multum(more);
  }
};

TEST_F(MaterialsCommandTest, TheViewerWarnsOfOtherMapsThanTheBakeHad) {
  write_waves("other_orm.png", 3, 0.4);
  write_waves("other_weights.png", 4, 0.9);
  write_waves("colours.png", 3, 1.0);
  const ProgramResult baked =
      bake("a.ndf.exr", {"--roughness", path("orm.png") + ":R", "--weights", path("weights.png"), "--albedo",
                         path("colours.png"), "--lobes", "2", "--no-start-search"});
  ASSERT_EQ(baked.exit_code, 0) << baked.err;
  const auto view = [&](const std::string& roughness, const std::string& weights, const std::string& albedo) {
    return run_program({std::string(MULTUM_BIN_DIR) + "/multum-view",
                        path("a.ndf.exr"),
                        "-o",
                        path("a.png"),
                        "--compare",
                        "reference",
                        "--source",
                        path("map_normal.png"),
                        "--roughness",
                        path(roughness),
                        "--weights",
                        path(weights),
                        "--albedo",
                        path(albedo),
                        "--samples",
                        "1",
                        "--size",
                        "16x12",
                        "--context",
                        "osmesa"});
  };
  ProgramResult viewed = view("orm.png:R", "weights.png", "colours.png");
  ASSERT_EQ(viewed.exit_code, 0) << viewed.err;
  EXPECT_FALSE(contains(viewed.err, "was baked with")) << viewed.err;
  viewed = view("other_orm.png:R", "other_weights.png", "other_orm.png");
  ASSERT_EQ(viewed.exit_code, 0) << viewed.err;
  for (const char* option : {"--roughness differs from", "--weights differs from", "--albedo differs from"})
    EXPECT_TRUE(contains(viewed.err, option)) << option << viewed.err;
  viewed = view("orm.png:G", "weights.png", "colours.png");
  EXPECT_TRUE(contains(viewed.err, "orm.png:G: --roughness differs from")) << "another channel" << viewed.err;
  EXPECT_FALSE(contains(viewed.err, "--weights differs from")) << viewed.err;
}

TEST_F(MaterialsCommandTest, BakesVerifiesAndSaysWhatItHolds) {
  for (const char* ndf : {"vmf", "moments", "gmm", "sh"}) {
    SCOPED_TRACE(ndf);
    std::vector<std::string> options = {
        "--ndf",        ndf, "--roughness", path("orm.png"), "--weights", path("weights.png"), "--report",
        path("a.json"), "-v"};
    append_options_of(ndf, options);
    const ProgramResult result = bake("a.ndf.exr", options);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.out, "roughness")) << result.out;
    EXPECT_FALSE(contains(result.out, "blinn-phong")) << result.out;
    const auto report = nlohmann::json::parse(read_bytes(path("a.json")));
    for (const auto& row : report["measured_error"]) EXPECT_TRUE(std::isfinite(row["relative_l1"].get<double>()));
    const BakedHeader header = read_baked_header(path("a.ndf.exr"));
    EXPECT_EQ(header.weight_count, 4);
    EXPECT_TRUE(header.has_roughness);
    EXPECT_GT(header.mean_cosine, 0.9f);
    EXPECT_LT(header.mean_cosine, 1.0f);
    const ProgramResult info = multum({"info", path("a.ndf.exr")});
    EXPECT_TRUE(contains(info.out, "mean cosine 0.9")) << info.out;
    expect_says(info.out, {"weights of 4"});
    const ProgramResult verify = multum({"verify", path("a.ndf.exr")});
    EXPECT_EQ(verify.exit_code, 0) << verify.out;
    expect_says(verify.out, {"4 weights", "roughness"});
    std::string bytes = read_bytes(path("a.ndf.exr"));
    for (std::size_t i = bytes.size() - 2000; i < bytes.size() - 1936; ++i) bytes[i] = static_cast<char>(bytes[i] ^ 16);
    std::ofstream(path("damaged.ndf.exr"), std::ios::binary) << bytes;
    EXPECT_NE(multum({"verify", path("damaged.ndf.exr")}).exit_code, 0);
  }
}

TEST_F(MaterialsCommandTest, TheirContentsAreWhatAFileIsRecognisedBy) {
  const std::vector<std::string> with = {
      "--roughness", path("orm.png") + ":G", "--weights", path("weights.png"), "--no-measure", "--ndf", "moments"};
  ASSERT_EQ(bake("a.ndf.exr", with).exit_code, 0);
  EXPECT_TRUE(contains(bake("a.ndf.exr", with).out, "unchanged"));
  std::vector<std::string> other = with;
  other[1] = path("orm.png") + ":B";
  EXPECT_FALSE(contains(bake("a.ndf.exr", other).out, "unchanged"));
  write_waves("weights.png", 4, 0.9);
  EXPECT_FALSE(contains(bake("a.ndf.exr", other).out, "unchanged"));
}

TEST_F(MaterialsCommandTest, ThreadsAndMemoryChangeNoByte) {
  for (const char* ndf : {"vmf", "moments", "gmm", "sh"}) {
    std::vector<std::string> options = {
        "--ndf",        ndf,         "--roughness", path("orm.png"), "--weights", path("weights.png"),
        "--no-measure", "--threads", "1",           "--memory",      "1G"};
    append_options_of(ndf, options);
    ASSERT_EQ(bake("a.ndf.exr", options).exit_code, 0);
    options[8] = "2";
    options[10] = "289M";
    ASSERT_EQ(bake("b.ndf.exr", options).exit_code, 0);
    EXPECT_EQ(read_bytes(path("a.ndf.exr")), read_bytes(path("b.ndf.exr"))) << ndf;
  }
}

TEST_F(MaterialsCommandTest, WhatCannotBeIsRefusedBeforeAnythingIsFitted) {
  write_waves("small.png", 3, 1.0);
  TestImage image{.width = 32, .height = 64, .channels = 1, .type = OIIO::TypeDesc::UINT8};
  image.values.assign(32 * 64, 0.5f);
  write_test_image(path("narrow.png"), image);
  ProgramResult result = bake("a.ndf.exr", {"--roughness", path("narrow.png")});
  expect_refusal(result, kInput, {"narrow.png: ", "32 x 64"});
  result = bake("a.ndf.exr", {"--roughness", path("orm.png") + ":A"});
  expect_refusal(result, kInput, {"orm.png", "no channel A"});
  result = bake("a.ndf.exr", {"--weights", path("none.png")});
  EXPECT_EQ(result.exit_code, 3) << result.err;
  // An input must not be overwritten, whatever its channel.
  result = multum({"bake", path("map_normal.png"), "-o", path("b.exr"), "--roughness", path("b.exr") + ":R"});
  EXPECT_EQ(result.exit_code, 2) << result.err;
  // Bakes of every representation refuse the map if a single texel is bad.
  write_rough_texel(NAN);
  for (const char* ndf : {"vmf", "gmm", "sh", "moments"}) {
    result = bake("a.ndf.exr", {"--ndf", ndf, "--roughness", path("rough.exr")});
    expect_refusal(result, kInput, {"rough.exr: ", "(5, 1)", "nan", "channel"});
  }
  EXPECT_FALSE(std::filesystem::exists(path("a.ndf.exr")));
}

// The command line, manifests and reports define gloss as 1 - roughness. A bake that reads a map as gloss does not
// count as a bake that reads the same map as roughness.
TEST_F(MaterialsCommandTest, GlossIsRoughnessTheOtherWayRound) {
  TestImage rough{.width = 64, .height = 64, .channels = 1, .type = OIIO::TypeDesc::FLOAT}, gloss = rough;
  for (int i = 0; i < 64 * 64; ++i) {
    rough.values.push_back(static_cast<float>(i % 64) / 64.0f);
    gloss.values.push_back(1.0f - rough.values.back());
  }
  write_test_image(path("rough.exr"), rough);
  write_test_image(path("gloss.exr"), gloss);
  const auto hash = [&](const std::string& name) { return read_baked_header(path(name)).provenance.content_hash; };
  const std::vector<std::string> moments = {"--ndf", "moments", "--green", "up"};
  const auto bake_with = [&](const std::string& output, std::vector<std::string> more) {
    more.insert(more.end(), moments.begin(), moments.end());
    return bake(output, more);
  };
  const ProgramResult by_roughness =
      bake_with("a.ndf.exr", {"--roughness", path("rough.exr"), "--report", path("a.json")});
  ASSERT_EQ(by_roughness.exit_code, 0) << by_roughness.err;
  const ProgramResult by_gloss = bake_with("b.ndf.exr", {"--gloss", path("gloss.exr"), "--report", path("b.json")});
  ASSERT_EQ(by_gloss.exit_code, 0) << by_gloss.err;
  EXPECT_EQ(hash("a.ndf.exr"), hash("b.ndf.exr"));
  expect_says(by_roughness.err, {"rough.exr: perceptual roughness 0 to 0.984, mean 0.492; 1.56 % at 0, 0 % at 1"});
  expect_says(by_gloss.err, {"gloss.exr: gloss", "1 - gloss", "perceptual roughness 0 to 0.984, mean 0.492"});
  for (const char* report : {"a.json", "b.json"}) {
    const auto json = nlohmann::json::parse(read_bytes(path(report)))["roughness"];
    EXPECT_NEAR(json["mean"].get<double>(), 63.0 / 128.0, 1e-6);
    EXPECT_EQ(json["share_at_0"], 1.0 / 64.0);
    EXPECT_EQ(json["warnings"].size(), 1u) << "a tenth of the map is a mirror";
  }
  EXPECT_FALSE(contains(bake_with("a.ndf.exr", {"--gloss", path("rough.exr")}).out, "unchanged"));
  EXPECT_NE(hash("a.ndf.exr"), hash("b.ndf.exr"));
  EXPECT_EQ(bake_with("a.ndf.exr", {"--gloss", path("gloss.exr"), "--roughness", path("rough.exr")}).exit_code, 2);
  EXPECT_EQ(bake_with("gloss.exr", {"--gloss", path("gloss.exr")}).exit_code, 2) << "an input must not be an output";
  std::ofstream(path("maps.toml")) << "[defaults]\nndf = \"moments\"\ngreen = \"up\"\nroughness = \"rough.exr\"\n"
                                      "[[map]]\ninput = \"map_normal.png\"\noutput = \"c.ndf.exr\"\n"
                                      "gloss = \"gloss.exr\"\n";
  ASSERT_EQ(multum({"bake", "--manifest", path("maps.toml")}).exit_code, 0);
  EXPECT_EQ(hash("c.ndf.exr"), hash("b.ndf.exr"));
  EXPECT_TRUE(contains(bake_with("b.ndf.exr", {"--gloss", path("gloss.exr")}).out, "unchanged"));
}

// Roughness widens the lobes and so blurs diffuse light. The correction uses the map's mean roughness, so an error
// remains where roughness varies.
TEST_F(MaterialsCommandTest, AnErrorOfDiffuseLightIsWarnedOf) {
  const auto warned = [&](float rougher) {
    TestImage rough{.width = 64, .height = 64, .channels = 1, .type = OIIO::TypeDesc::FLOAT};
    for (int i = 0; i < 64 * 64; ++i) rough.values.push_back(i % 64 < 32 ? 0.5f : rougher);
    write_test_image(path("rough.exr"), rough);
    const ProgramResult result =
        bake("a.ndf.exr", {"--roughness", path("rough.exr"), "--lobes", "1", "--report", path("a.json")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const auto warnings = nlohmann::json::parse(read_bytes(path("a.json")))["roughness"]["warnings"];
    if (warnings.empty()) return std::string();
    EXPECT_TRUE(contains(result.err, "warning: " + warnings[0].get<std::string>())) << result.err;
    return warnings[0].get<std::string>();
  };
  EXPECT_EQ(warned(0.5f), "");
  expect_says(warned(1.0f), {"map_normal.png: ", "diffuse light", "levels 0 and 1", "--roughness"});
}

// Roughness 0 gives single directions, and roughness 1 gives the widest lobes.
TEST_F(MaterialsCommandTest, NoneAndAllOfIt) {
  for (const char* ndf : {"gmm", "sh"})
    for (const float value : {0.0f, 1.0f}) {
      TestImage image{.width = 64, .height = 64, .channels = 1, .type = OIIO::TypeDesc::FLOAT};
      image.values.assign(64 * 64, value);
      write_test_image(path("rough.exr"), image);
      std::vector<std::string> options = {"--ndf", ndf, "--roughness", path("rough.exr"), "--force"};
      append_options_of(ndf, options);
      const ProgramResult result = bake("a.ndf.exr", options);
      EXPECT_EQ(result.exit_code, 0) << result.err;
      EXPECT_EQ(read_baked_header(path("a.ndf.exr")).mean_cosine, value == 0.0f ? 1.0f : 0.5f);
      EXPECT_EQ(multum({"verify", path("a.ndf.exr")}).exit_code, 0) << ndf << " " << value;
    }
}

TEST_F(MaterialsCommandTest, ManifestsHaveTheSameKeys) {
  std::ofstream(path("maps.toml")) << R"([defaults]
lobes = 2
no_start_search = true
weights = "weights.png"
[[map]]
input = "map_normal.png"
output = "a.ndf.exr"
roughness = "orm.png:G"
[[map]]
input = "map_normal.png"
output = "b.ndf.exr"
weights = ""
)";
  ASSERT_EQ(multum({"bake", "--manifest", path("maps.toml")}).exit_code, 0);
  EXPECT_EQ(read_baked_header(path("a.ndf.exr")).format_version(), 4);
  EXPECT_EQ(read_baked_header(path("b.ndf.exr")).format_version(), 3);
  // The manifest gives the same bake as the command line.
  EXPECT_TRUE(contains(bake("a.ndf.exr", {"--lobes", "2", "--no-start-search", "--weights", path("weights.png"),
                                          "--roughness", path("orm.png") + ":G"})
                           .out,
                       "unchanged"));
}

}  // namespace
}  // namespace multum::testing
