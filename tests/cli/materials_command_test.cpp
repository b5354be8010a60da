// SPDX-License-Identifier: Apache-2.0
// multum bake --roughness and --weights: what the file holds, what it is recognised by, in manifests and for every
// representation.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/asset/moment_mipmap.h"
#include "host/asset/movmf_mipmap.h"
#include "tests/cli/program.h"
#include "tests/unit/image_test_files.h"

namespace multum::testing {
namespace {

class MaterialsCommandTest : public CliTest {
 protected:
  void SetUp() override {
    make_map("map", 64);
    // glTF's order: occlusion, roughness, metalness; then weights of four.
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
  // None but for one texel.
  void write_rough_texel(float value) const {
    TestImage image{.width = 64, .height = 64, .channels = 1, .type = OIIO::TypeDesc::FLOAT};
    image.values.assign(64 * 64, 0.0f);
    image.values[64 + 5] = value;
    write_test_image(path("rough.exr"), image);
  }
  static void append_options_of(const std::string& ndf, std::vector<std::string>& options) {
    if (ndf == "vmf" || ndf == "gmm") options.insert(options.end(), {"--no-rehearsal", "--lobes", "2"});
    if (ndf == "sh") options.insert(options.end(), {"--sh-order", "2"});
  }
  ProgramResult bake(const std::string& output, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"bake", path("map_normal.png"), "-o", path(output)});
    return multum(more);
  }
};

TEST_F(MaterialsCommandTest, BakesVerifiesAndSaysWhatItHolds) {
  for (const char* ndf : {"vmf", "moments", "gmm", "sh"}) {
    SCOPED_TRACE(ndf);
    std::vector<std::string> options = {
        "--ndf", ndf, "--roughness", path("orm.png"), "--weights", path("weights.png"), "--report", path("a.json")};
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
  // What is read must not be written over, whatever its channel.
  result = multum({"bake", path("map_normal.png"), "-o", path("b.exr"), "--roughness", path("b.exr") + ":R"});
  EXPECT_EQ(result.exit_code, 2) << result.err;
  // Of every representation: not even one texel.
  write_rough_texel(NAN);
  for (const char* ndf : {"vmf", "gmm", "sh", "moments"}) {
    result = bake("a.ndf.exr", {"--ndf", ndf, "--roughness", path("rough.exr")});
    expect_refusal(result, kInput, {"rough.exr: ", "(5, 1)", "nan", "channel"});
  }
  EXPECT_FALSE(std::filesystem::exists(path("a.ndf.exr")));
}

// No roughness, and all of it: single directions, and the widest lobes.
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
no_rehearsal = true
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
  // As the command line makes it.
  EXPECT_TRUE(contains(bake("a.ndf.exr", {"--lobes", "2", "--no-rehearsal", "--weights", path("weights.png"),
                                          "--roughness", path("orm.png") + ":G"})
                           .out,
                       "unchanged"));
}

}  // namespace
}  // namespace multum::testing
