// SPDX-License-Identifier: Apache-2.0
// Tests multum bake --ndf sh: the file, the reported errors, the changes that it notices, and its refusals.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class ShCommandTest : public CliTest {
 protected:
  ProgramResult bake(const std::string& input, const std::string& output, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"bake", "--ndf", "sh", path(input), "-o", path(output)});
    return multum(more);
  }
  std::string hash(const std::string& name) const { return read_baked_header(path(name)).provenance.content_hash; }
};

TEST_F(ShCommandTest, BakesVerifiesAndSaysWhatItHolds) {
  make_map("map", 64);
  const ProgramResult result =
      bake("map_normal.png", "map.ndf.exr",
           {"--albedo", path("map_albedo.png"), "--report", path("map.json"), "--runstats", "--sh-order", "8"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* part : {"measured error, relative L1", "measured error with colours, relative L1",
                           "spherical harmonics to order 8 of 64 x 64: one pass in bands of"})
    EXPECT_TRUE(contains(result.out, part)) << part << " is not in\n" << result.out;
  EXPECT_FALSE(contains(result.out, " lobes:")) << "no lobes are counted: " << result.out;

  const auto report = nlohmann::json::parse(read_bytes(path("map.json")));
  EXPECT_EQ(report["counts"]["nonfinite"], 0);
  EXPECT_GT(report["launches"]["sh_project"], 0);
  EXPECT_GT(report["launches"]["mip_levels"], 0);
  EXPECT_FALSE(report["launches"].contains("moment_finest"));
  // Each of the 7 levels has the errors of 4 BRDFs, with and without colours, at 4 points. Only the last level has a
  // single point.
  EXPECT_EQ(report["measured_error"].size(), (6u * 4u + 1u) * 8u);
  for (const auto& row : report["measured_error"]) {
    EXPECT_TRUE(std::isfinite(row["relative_l1"].get<double>()));
    EXPECT_LT(row["relative_l1"].get<double>(), 2.0) << row.dump();
    // This holds for every level. An error with colours compares the product of two averages, as in every file with one
    // colour per texel.
    if (row["brdf"] == "lambert") {
      EXPECT_LT(row["relative_l1"].get<double>(), 0.015) << row.dump();
    }
  }

  const ProgramResult info = multum({"info", path("map.ndf.exr")});
  for (const char* line :
       {"representation  sh: spherical harmonics to order 8: 80 coefficients in 20 textures, mean colour",
        "64 x 64, 7 levels", "encoding        half", "\"sh_order\":8"})
    EXPECT_TRUE(contains(info.out, line)) << line << " is not in\n" << info.out;
  const ProgramResult verify = multum({"verify", path("map.ndf.exr")});
  EXPECT_EQ(verify.exit_code, 0) << verify.out;
  EXPECT_EQ(std::count(verify.out.begin(), verify.out.end(), '\n'), 6) << verify.out;
}

TEST_F(ShCommandTest, OrdersAreOtherFilesWhoseFirstCoefficientsAreTheSame) {
  make_map("map", 32);
  ASSERT_EQ(bake("map_normal.png", "four.ndf.exr", {"-d", "float", "--no-measure"}).exit_code, 0);
  EXPECT_TRUE(contains(bake("map_normal.png", "four.ndf.exr", {"-d", "float", "--no-measure"}).out, "unchanged"));
  EXPECT_TRUE(contains(bake("map_normal.png", "four.ndf.exr", {"-d", "float", "--sh-order", "4", "--no-measure"}).out,
                       "unchanged"));
  const std::string first = hash("four.ndf.exr");
  ASSERT_EQ(bake("map_normal.png", "two.ndf.exr", {"-d", "float", "--sh-order", "2", "--no-measure"}).exit_code, 0);
  const ShMipmap four = read_sh_mipmap(path("four.ndf.exr")), two = read_sh_mipmap(path("two.ndf.exr"));
  EXPECT_EQ(four.order, 4);
  EXPECT_EQ(two.order, 2);
  for (std::size_t l = 0; l < two.levels.size(); ++l)
    for (std::size_t p = 0; p < two.levels[l].parts.size(); ++p)
      EXPECT_TRUE(two.levels[l].parts[p] == four.levels[l].parts[p]) << l;
  // A bake with another order replaces the file, and a further bake with the old order restores it.
  EXPECT_FALSE(contains(bake("map_normal.png", "four.ndf.exr", {"-d", "float", "--sh-order", "3"}).out, "unchanged"));
  EXPECT_NE(hash("four.ndf.exr"), first);
  ASSERT_EQ(bake("map_normal.png", "four.ndf.exr", {"-d", "float", "--no-measure"}).exit_code, 0);
  EXPECT_EQ(hash("four.ndf.exr"), first);
}

TEST_F(ShCommandTest, ThreadsMemoryAndFirstLevelsChangeNoPixel) {
  TestImage image = normal_image(300, 131);
  image.type = OIIO::TypeDesc::UINT16;
  write_test_image(path("map.png"), image);
  const std::vector<std::string> usual = {"--no-measure", "--wrap", "clamp"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.end(), usual.begin(), usual.end());
    return more;
  };
  ASSERT_EQ(bake("map.png", "a.ndf.exr", with({"--threads", "2"})).exit_code, 0);
  ASSERT_EQ(bake("map.png", "b.ndf.exr", with({"--threads", "1", "--memory", "289M", "--scalar"})).exit_code, 0);
  EXPECT_EQ(read_bytes(path("a.ndf.exr")), read_bytes(path("b.ndf.exr")));
  ASSERT_EQ(bake("map.png", "c.ndf.exr", with({"--first-level", "3"})).exit_code, 0);
  const ShMipmap whole = read_sh_mipmap(path("a.ndf.exr")), coarse = read_sh_mipmap(path("c.ndf.exr"));
  for (std::size_t l = 0; l < whole.levels.size(); ++l) {
    if (l < 3) EXPECT_TRUE(coarse.levels[l].parts.empty());
    else EXPECT_TRUE(coarse.levels[l].parts == whole.levels[l].parts) << l;
  }
  EXPECT_EQ(multum({"verify", path("c.ndf.exr")}).exit_code, 0);
}

TEST_F(ShCommandTest, WhatFitsNoHarmonicsIsRefused) {
  make_map("map", 32);
  const auto refused = [&](const std::vector<std::string>& more, const std::vector<std::string>& parts) {
    expect_refusal(bake("map_normal.png", "map.ndf.exr", more), kUsage, parts);
    EXPECT_FALSE(std::filesystem::exists(path("map.ndf.exr")));
  };
  refused({"--sh-order", "0"}, {"--sh-order", "0", "1 to 20"});
  refused({"--sh-order", "21"}, {"--sh-order", "21", "1 to 20"});
  refused({"--lobes", "6"}, {"--lobes", "with --ndf vmf"});
  refused({"-d", "snorm16"}, {"--data-format", "snorm16", "half", "float", "--ndf sh"});
  refused({"--region", "0,0,8,8", "--onto", path("old.ndf.exr")}, {"--region", "--onto", "with --ndf vmf"});
  const ProgramResult other = multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--sh-order", "4"});
  expect_refusal(other, kUsage, {"--sh-order", "only with --ndf sh", "found --ndf vmf"});
}

TEST_F(ShCommandTest, AManifestBakesAndChecksIt) {
  make_map("map", 64);
  write_bytes(path("maps.toml"),
              "[defaults]\nsh_order = 2\n[[map]]\ninput = \"map_normal.png\"\noutput = \"moments.ndf.exr\"\n"
              "ndf = \"moments\"\n[[map]]\ninput = \"map_normal.png\"\noutput = \"sh.ndf.exr\"\nndf = \"sh\"\n");
  const ProgramResult baked = multum({"bake", "--manifest", path("maps.toml")});
  ASSERT_EQ(baked.exit_code, 0) << baked.err;
  EXPECT_EQ(read_sh_header(path("sh.ndf.exr")).order, 2);
  const ProgramResult check = multum({"bake", "--manifest", path("maps.toml"), "--check"});
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  write_bytes(path("maps.toml"), "[[map]]\ninput = \"map_normal.png\"\noutput = \"lobes.ndf.exr\"\nsh_order = 2\n");
  const ProgramResult refused = multum({"bake", "--manifest", path("maps.toml")});
  expect_refusal(refused, kInput, {"maps.toml:4: ", "sh_order", "ndf = \"sh\""});
}

}  // namespace
}  // namespace multum::testing
