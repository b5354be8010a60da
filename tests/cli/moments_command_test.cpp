// SPDX-License-Identifier: Apache-2.0
// Tests multum bake --ndf moments: the file, the reported errors, the changes that it notices, its refusals, and a
// comparison with maketx --bumpslopes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

// Flips a bit near the end of the file. The pixels are there, after the long headers.
void flip_a_pixel(std::string& bytes) {
  char& byte = bytes[bytes.size() - 2000];
  byte = static_cast<char>(byte ^ 16);
}

class MomentsCommandTest : public CliTest {
 protected:
  ProgramResult bake(const std::string& input, const std::string& output, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"bake", "--ndf", "moments", path(input), "-o", path(output)});
    return multum(more);
  }
  std::string hash(const std::string& name) const { return read_baked_header(path(name)).provenance.content_hash; }
  /// Writes normals as a signed EXR of floats, whose encoding needs no statistics.
  void make_exr(const std::string& name, int width, int height) const {
    TestImage image = normal_image(width, height, true);
    image.type = OIIO::TypeDesc::FLOAT;
    write_test_image(path(name), image);
  }
};

TEST_F(MomentsCommandTest, BakesVerifiesAndSaysWhatItHolds) {
  make_map("map", 64);
  const ProgramResult result = bake("map_normal.png", "map.ndf.exr",
                                    {"--albedo", path("map_albedo.png"), "--report", path("map.json"), "--runstats"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* part : {"measured error of toksvig, relative L1", "measured error of lean, relative L1",
                           "measured error of lean-jacobian, relative L1",
                           "measured error of lean-jacobian with colours, relative L1", "one pass in bands of"})
    EXPECT_TRUE(contains(result.out, part)) << part << " is not in\n" << result.out;
  EXPECT_FALSE(contains(result.out, " lobes:")) << "no lobes are counted: " << result.out;

  const auto report = nlohmann::json::parse(read_bytes(path("map.json")));
  EXPECT_EQ(report["counts"]["nonfinite"], 0);
  EXPECT_GT(report["launches"]["mip_levels"], 0);
  EXPECT_FALSE(report["launches"].contains("movmf_em_texels")) << "nothing is fitted";
  // Each of the 7 levels has the errors of 4 BRDFs for 3 ways of shading, with and without colours, at 4 points. Only
  // the last level has a single point.
  EXPECT_EQ(report["measured_error"].size(), (6u * 4u + 1u) * 24u);
  for (const auto& row : report["measured_error"]) {
    EXPECT_TRUE(std::isfinite(row["relative_l1"].get<double>()));
    EXPECT_LT(row["relative_l1"].get<double>(), 3.0) << row.dump();
  }

  const ProgramResult info = multum({"info", path("map.ndf.exr")});
  for (const char* line :
       {"representation  moments: mean normal, first and second moments of slopes, mean colour", "64 x 64, 7 levels",
        "encoding        half; at a slope b, stores deviations of slopes as small as 0.0442 b",
        "\"representation\":\"moments\""})
    EXPECT_TRUE(contains(info.out, line)) << line << " is not in\n" << info.out;
  const std::string table = measured_tables(result.out);
  EXPECT_FALSE(table.empty());
  EXPECT_TRUE(contains(info.out, table)) << info.out;
  const ProgramResult verify = multum({"verify", path("map.ndf.exr")});
  EXPECT_EQ(verify.exit_code, 0) << verify.out;
  EXPECT_EQ(std::count(verify.out.begin(), verify.out.end(), '\n'), 7) << verify.out;
}

// Help lists the most accurate representation first, which is also the default.
TEST_F(MomentsCommandTest, HelpNamesLobesFirst) {
  const std::string help = multum({"bake", "--help"}).out;
  EXPECT_TRUE(std::regex_search(help, std::regex("--ndf[^\\n]*vmf[^-]*"))) << help;
  const std::size_t vmf = help.find("vmf (lobes"), moments = help.find("moments (slope");
  ASSERT_NE(vmf, std::string::npos) << help;
  ASSERT_NE(moments, std::string::npos) << help;
  EXPECT_LT(vmf, moments);
}

TEST_F(MomentsCommandTest, IsRecognisedAndBakedAgainOnlyWhenItMustBe) {
  make_map("map", 32);
  ASSERT_EQ(bake("map_normal.png", "map.ndf.exr").exit_code, 0);
  const std::string first = hash("map.ndf.exr");
  EXPECT_TRUE(contains(bake("map_normal.png", "map.ndf.exr").out, "unchanged"));
  EXPECT_FALSE(contains(bake("map_normal.png", "map.ndf.exr", {"--force"}).out, "unchanged"));
  EXPECT_EQ(hash("map.ndf.exr"), first);
  EXPECT_FALSE(contains(bake("map_normal.png", "map.ndf.exr", {"-d", "float"}).out, "unchanged"));
  EXPECT_NE(hash("map.ndf.exr"), first);
  // A file of another representation is not up to date.
  const ProgramResult lobes = multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr")});
  EXPECT_EQ(lobes.exit_code, 0);
  EXPECT_FALSE(contains(lobes.out, "unchanged"));
  EXPECT_FALSE(contains(bake("map_normal.png", "map.ndf.exr").out, "unchanged"));
  EXPECT_EQ(hash("map.ndf.exr"), first);
}

TEST_F(MomentsCommandTest, ThreadsMemoryAndScalarKernelsChangeNoByte) {
  TestImage image = normal_image(700, 331);
  image.type = OIIO::TypeDesc::UINT16;
  write_test_image(path("map.png"), image);
  ASSERT_EQ(bake("map.png", "a.ndf.exr", {"--threads", "2"}).exit_code, 0);
  ASSERT_EQ(bake("map.png", "b.ndf.exr", {"--threads", "1", "--memory", "289M"}).exit_code, 0);
  ASSERT_EQ(bake("map.png", "c.ndf.exr", {"--scalar", "--memory", "1G"}).exit_code, 0);
  const std::string bytes = read_bytes(path("a.ndf.exr"));
  EXPECT_EQ(read_bytes(path("b.ndf.exr")), bytes);
  EXPECT_EQ(read_bytes(path("c.ndf.exr")), bytes);
}

TEST_F(MomentsCommandTest, FirstLevelsStoreTheSamePixelsFromThereOn) {
  make_map("map", 64);
  ASSERT_EQ(bake("map_normal.png", "whole.ndf.exr", {"--report", path("whole.json")}).exit_code, 0);
  const MomentMipmap whole = read_moment_mipmap(path("whole.ndf.exr"));
  const auto measured = [&](const std::string& name) {
    return nlohmann::json::parse(read_bytes(path(name)))["measured_error"];
  };
  for (const int first_level : {1, 6}) {
    SCOPED_TRACE(first_level);
    const ProgramResult result = bake("map_normal.png", "map.ndf.exr",
                                      {"--first-level", std::to_string(first_level), "--report", path("map.json")});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    expect_says(result.out, {fmt::format("finer than {}", first_level), "not stored"});
    const MomentMipmap mipmap = read_moment_mipmap(path("map.ndf.exr"));
    for (std::size_t l = 0; l < mipmap.levels.size(); ++l) {
      const bool is_stored = l >= static_cast<std::size_t>(first_level);
      EXPECT_TRUE(is_stored ? mipmap.levels[l].normals == whole.levels[l].normals : mipmap.levels[l].normals.empty());
    }
    EXPECT_EQ(multum({"verify", path("map.ndf.exr")}).exit_code, 0);
    ASSERT_EQ(measured("map.json").size(), measured("whole.json").size()) << "every level is measured";
    for (std::size_t i = 0; i < measured("map.json").size(); ++i) {
      const auto row = measured("map.json")[i], same = measured("whole.json")[i];
      if (row["level"] < first_level) continue;
      EXPECT_EQ(row["relative_l1"], same["relative_l1"]) << row.dump();
    }
  }
  EXPECT_EQ(bake("map_normal.png", "none.ndf.exr", {"--first-level", "7"}).exit_code, 2);
}

TEST_F(MomentsCommandTest, WhatFitsNoMomentsIsRefused) {
  make_map("map", 32);
  const auto refused = [&](const std::vector<std::string>& more, const std::vector<std::string>& parts) {
    expect_refusal(bake("map_normal.png", "map.ndf.exr", more), kUsage, parts);
    EXPECT_FALSE(std::filesystem::exists(path("map.ndf.exr")));
  };
  refused({"--lobes", "6"}, {"--lobes", "with --ndf vmf"});
  refused({"--reference"}, {"--reference", "with --ndf vmf"});
  refused({"--align", "0.1"}, {"--align", "with --ndf vmf"});
  refused({"-d", "snorm16"}, {"--data-format", "snorm16", "half", "float", "--ndf moments"});
  refused({"--region", "0,0,8,8", "--onto", path("old.ndf.exr")}, {"--region", "--onto", "with --ndf vmf"});
  refused({"--ndf", "gmm"}, {"--ndf"});
}

// NaN and normals below the horizon are repaired, as in every bake. Near the horizon, slopes are limited, and the
// limited slopes are counted.
TEST_F(MomentsCommandTest, BrokenAndSteepNormalsAreRepairedAndCounted) {
  TestImage image = normal_image(64, 64, true);
  image.type = OIIO::TypeDesc::FLOAT;
  for (int c = 0; c < 3; ++c) image.at(5, 7, c) = std::numeric_limits<float>::quiet_NaN();
  const float low[] = {0.8f, 0.0f, -0.6f}, rim[] = {0.0f, 1.0f, 0.01f};
  for (int c = 0; c < 3; ++c) {
    image.at(20, 30, c) = low[c];
    for (int x = 40; x < 60; ++x) image.at(x, 50, c) = rim[c];
  }
  write_test_image(path("map.exr"), image);
  const ProgramResult result = bake("map.exr", "map.ndf.exr", {"--report", path("map.json"), "--signed"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.out, "1 were not finite, 0 had zero length, 1 were below")) << result.out;
  expect_says(result.out, {"21 normals", "horizon"});
  EXPECT_EQ(nlohmann::json::parse(read_bytes(path("map.json")))["counts"]["slopes_limited"], 21);
  EXPECT_EQ(multum({"verify", path("map.ndf.exr")}).exit_code, 0);
  for (const MomentLevel& level : read_moment_mipmap(path("map.ndf.exr")).levels)
    for (const SlopeMoments& m : level.slopes) EXPECT_TRUE(std::isfinite(m.ss) && m.ss <= 400.0f && m.tt <= 400.0f);
}

TEST_F(MomentsCommandTest, DamageIsFound) {
  make_map("map", 64);
  ASSERT_EQ(bake("map_normal.png", "map.ndf.exr", {"--compression", "none"}).exit_code, 0);
  std::string bytes = read_bytes(path("map.ndf.exr"));
  flip_a_pixel(bytes);
  write_bytes(path("map.ndf.exr"), bytes);
  const ProgramResult verify = multum({"verify", path("map.ndf.exr")});
  EXPECT_EQ(verify.exit_code, 5) << verify.out;
  EXPECT_TRUE(contains(verify.out, "FAILED checksum")) << verify.out;
  write_bytes(path("map.ndf.exr"), bytes.substr(0, bytes.size() - 3000));
  EXPECT_EQ(multum({"verify", path("map.ndf.exr")}).exit_code, 3);
}

TEST_F(MomentsCommandTest, AManifestBakesAndChecksBoth) {
  make_map("map", 64);
  write_bytes(path("maps.toml"),
              "[defaults]\nlobes = 2\n[[map]]\ninput = \"map_normal.png\"\noutput = \"lobes.ndf.exr\"\n"
              "[[map]]\ninput = \"map_normal.png\"\noutput = \"moments.ndf.exr\"\nndf = \"moments\"\n");
  ASSERT_EQ(multum({"bake", "--manifest", path("maps.toml")}).exit_code, 0);
  EXPECT_EQ(read_baked_header(path("lobes.ndf.exr")).representation, Representation::kMovmf);
  EXPECT_EQ(read_baked_header(path("moments.ndf.exr")).representation, Representation::kMoments);
  const ProgramResult check = multum({"bake", "--manifest", path("maps.toml"), "--check"});
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  std::string bytes = read_bytes(path("moments.ndf.exr"));
  flip_a_pixel(bytes);
  write_bytes(path("moments.ndf.exr"), bytes);
  EXPECT_NE(multum({"bake", "--manifest", path("maps.toml"), "--check"}).exit_code, 0);
  write_bytes(path("maps.toml"),
              "[[map]]\ninput = \"map_normal.png\"\noutput = \"moments.ndf.exr\"\nndf = \"moments\"\nlobes = 2\n");
  const ProgramResult refused = multum({"bake", "--manifest", path("maps.toml")});
  expect_refusal(refused, kInput, {"maps.toml:5: ", "lobes", "ndf = \"vmf\""});
}

// Reads all levels of the first part, [level][texel][channel].
std::vector<std::vector<float>> read_first_part(const std::string& path, int channel_count) {
  std::vector<std::vector<float>> levels;
  const auto in = OIIO::ImageInput::open(path);
  for (int l = 0; in != nullptr && in->seek_subimage(0, l); ++l) {
    const OIIO::ImageSpec& spec = in->spec();
    EXPECT_EQ(spec.nchannels, channel_count);
    levels.emplace_back(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
    EXPECT_TRUE(in->read_image(0, l, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, levels.back().data()));
  }
  return levels;
}

// The six channels have the same names, order and signs as maketx's channels. This holds for inputs that maketx handles
// correctly: they are signed, and their sizes can be halved.
TEST_F(MomentsCommandTest, TheFirstPartIsWhatMaketxWrites) {
  if (!program_works("maketx", "--help")) GTEST_SKIP() << "no maketx (Debian package openimageio-tools)";
  make_exr("map.exr", 64, 32);
  ASSERT_EQ(bake("map.exr", "map.ndf.exr", {"--signed", "--green", "up", "-d", "float", "--no-measure"}).exit_code, 0);
  const ProgramResult maketx =
      run_program({"maketx", "--bumpslopes", "-d", "float", path("map.exr"), "-o", path("maketx.exr")});
  ASSERT_EQ(maketx.exit_code, 0) << maketx.err;
  const auto ours = read_first_part(path("map.ndf.exr"), 6), theirs = read_first_part(path("maketx.exr"), 6);
  ASSERT_EQ(ours.size(), 7u);
  ASSERT_EQ(theirs.size(), ours.size());
  for (std::size_t l = 0; l < ours.size(); ++l) {
    ASSERT_EQ(theirs[l].size(), ours[l].size());
    for (std::size_t i = 0; i < ours[l].size(); ++i)
      ASSERT_NEAR(static_cast<double>(ours[l][i]), static_cast<double>(theirs[l][i]), 2e-6)
          << "level " << l << ", channel " << i % 6;
  }
  const auto in = OIIO::ImageInput::open(path("map.ndf.exr")), reference = OIIO::ImageInput::open(path("maketx.exr"));
  EXPECT_EQ(in->spec().channelnames, reference->spec().channelnames);
}

// maketx wrongly treats the values 0..1 of a usual normal map as -1..1. multum decodes them.
TEST_F(MomentsCommandTest, UnsignedMapsAreDecodedWhereMaketxTakesThemForSigned) {
  make_exr("signed.exr", 64, 64);
  TestImage image = normal_image(64, 64);
  image.type = OIIO::TypeDesc::UINT16;
  write_test_image(path("unsigned.png"), image);
  const std::vector<std::string> exact = {"--green", "up", "-d", "float", "--no-measure"};
  ASSERT_EQ(bake("signed.exr", "signed.ndf.exr", exact).exit_code, 0);
  ASSERT_EQ(bake("unsigned.png", "unsigned.ndf.exr", exact).exit_code, 0);
  const auto from_signed = read_first_part(path("signed.ndf.exr"), 6).back();
  const auto from_unsigned = read_first_part(path("unsigned.ndf.exr"), 6).back();
  for (std::size_t c = 0; c < 6; ++c) EXPECT_NEAR(from_unsigned[c], from_signed[c], 1e-4f) << c;
  if (!program_works("maketx", "--help")) GTEST_SKIP() << "no maketx (Debian package openimageio-tools)";
  ASSERT_EQ(run_program({"maketx", "--bumpslopes", "-d", "float", path("unsigned.png"), "-o", path("x.exr")}).exit_code,
            0);
  EXPECT_GT(std::abs(read_first_part(path("x.exr"), 6).back()[1] - from_signed[1]), 0.3f)
      << "maketx no longer has this fault; update the docs";
}

}  // namespace
}  // namespace multum::testing
