// SPDX-License-Identifier: Apache-2.0
// Tests successful bakes: the file, the report, the progress bar and the help. Also tests that every bake gives the
// same bytes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <regex>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/files/content_hash.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class BakeCommandTest : public CliTest {};

TEST_F(BakeCommandTest, InfoAndVerifyAcceptWhatWasBaked) {
  make_map("map", 64);
  const ProgramResult bake =
      multum({"bake", path("map_normal.png"), "--albedo", path("map_albedo.png"), "-o", path("map.ndf.exr"), "-v"});
  ASSERT_EQ(bake.exit_code, 0) << bake.err;
  EXPECT_TRUE(contains(bake.out, "map.ndf.exr: written")) << bake.out;
  // Without neighbours there are no midway points.
  expect_says(bake.out, {"measured error, relative L1", "measured error with colours, relative L1", " | -\n"});
  EXPECT_FALSE(contains(bake.out, "| 0.00\n")) << bake.out;
  EXPECT_TRUE(contains(bake.err, "map_normal.png: 64 x 64")) << bake.err;
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"map_normal.png", "map_albedo.png", "map.ndf.exr"}));

  const ProgramResult info = multum({"info", path("map.ndf.exr")});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  for (const char* line : {"4 von Mises-Fisher lobes", "colour", "64 x 64, 7 levels", "snorm16",
                           "map_normal.png, SHA-256", "\"lobes\":4", "\"height_scale\":1.0",
                           // The following fields describe the source map.
                           "source format   png uint16, 3 channels", "read as         normal map, unsigned, green",
                           "because         length within", "wrap of source  periodic, periodic",
                           "albedo          png uint16, 3 channels, sRGB"})
    EXPECT_TRUE(contains(info.out, line)) << line << " is not in\n" << info.out;
  EXPECT_FALSE(std::regex_search(info.out, std::regex("\":[0-9.]{9}"))) << "floats are not rounded in\n" << info.out;
  const std::string table = measured_tables(bake.out);
  EXPECT_FALSE(table.empty());
  EXPECT_TRUE(contains(info.out, table)) << "the bake printed\n" << table << "info prints\n" << info.out;

  const ProgramResult verify = multum({"verify", path("map.ndf.exr")});
  EXPECT_EQ(verify.exit_code, 0) << verify.err;
  EXPECT_FALSE(contains(verify.out, "FAILED")) << verify.out;
  EXPECT_EQ(std::count(verify.out.begin(), verify.out.end(), '\n'), 7) << verify.out;
}

TEST_F(BakeCommandTest, WhatWasBakedIsNoMap) {
  make_map("map", 32);
  for (const char* ndf : {"vmf", "moments"}) {
    ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", path("a.ndf.exr"), "--ndf", ndf, "--force", "--no-measure"})
                  .exit_code,
              0);
    std::filesystem::copy_file(path("a.ndf.exr"), path("renamed.exr"),
                               std::filesystem::copy_options::overwrite_existing);
    for (const char* file : {"a.ndf.exr", "renamed.exr"})
      for (const char* command : {"bake", "mip", "tradeoff"}) {
        const ProgramResult refused = multum({command, path(file), "-o", path("b.exr")});
        EXPECT_EQ(refused.exit_code, 3) << refused.err;
        expect_says(refused.err, {path(file), "multum baked from map_normal.png", "Use map_normal.png itself",
                                  "multum export", "multum-view", "multum info"});
      }
  }
  EXPECT_FALSE(std::filesystem::exists(path("b.exr")));
}

TEST_F(BakeCommandTest, VerifyAcceptsEveryStorage) {
  make_map("map", 256);
  for (const char* storage : {"snorm16", "half", "float"}) {
    const ProgramResult bake = multum({"bake", path("map_normal.png"), "--albedo", path("map_albedo.png"), "-o",
                                       path("map.ndf.exr"), "--data-format", storage, "--no-measure", "--quiet"});
    ASSERT_EQ(bake.exit_code, 0) << bake.err;
    const ProgramResult verify = multum({"verify", path("map.ndf.exr")});
    EXPECT_EQ(verify.exit_code, 0) << storage << "\n" << verify.out << verify.err;
  }
}

TEST_F(BakeCommandTest, FirstLevelStoresTheSamePixelsFromThereOn) {
  make_map("map", 64);
  const auto bake = [&](const std::string& first_level, const std::string& name) {
    const ProgramResult result =
        multum({"bake", path("map_normal.png"), "--albedo", path("map_albedo.png"), "-o", path(name + ".ndf.exr"),
                "--first-level", first_level, "--report", path(name + ".json"), "-v"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result;
  };
  bake("0", "whole");
  const MovmfMipmap whole = read_movmf_mipmap(path("whole.ndf.exr"));
  for (const int first_level : {1, 2, 6}) {
    SCOPED_TRACE(first_level);
    const ProgramResult result = bake(std::to_string(first_level), "map");
    expect_says(result.out, {fmt::format("finer than {}", first_level), "not stored", "normal map"});
    const MovmfMipmap mipmap = read_movmf_mipmap(path("map.ndf.exr"));
    EXPECT_EQ(mipmap.header.first_level, first_level);
    ASSERT_EQ(mipmap.levels.size(), whole.levels.size());
    for (std::size_t l = 0; l < whole.levels.size(); ++l)
      for (std::size_t j = 0; j < 4; ++j) {
        const bool stored = l >= static_cast<std::size_t>(first_level);
        EXPECT_TRUE(stored ? mipmap.levels[l].lobes[j] == whole.levels[l].lobes[j] : mipmap.levels[l].lobes[j].empty());
        EXPECT_TRUE(stored ? mipmap.levels[l].colours[j] == whole.levels[l].colours[j]
                           : mipmap.levels[l].colours[j].empty());
      }
    EXPECT_LT(std::filesystem::file_size(path("map.ndf.exr")), std::filesystem::file_size(path("whole.ndf.exr")));

    const auto report = nlohmann::json::parse(read_bytes(path("map.json")));
    EXPECT_EQ(report["levels"].size(), 7u - static_cast<std::size_t>(first_level));
    EXPECT_EQ(report["levels"][0]["level"], first_level) << "finer levels must not be fitted";
    const auto measured = [&](const std::string& name) {
      return nlohmann::json::parse(read_bytes(path(name)))["measured_error"];
    };
    EXPECT_EQ(measured("map.json").size(), measured("whole.json").size()) << "every level is measured";

    const ProgramResult verify = multum({"verify", path("map.ndf.exr")});
    EXPECT_EQ(verify.exit_code, 0) << verify.out;
    const std::string levels = first_level == 6 ? "64 x 64, level 6 of 0 to 6, "
                                                : fmt::format("64 x 64, levels {} to 6 of 0 to 6, ", first_level);
    EXPECT_TRUE(contains(verify.out, levels)) << verify.out;
    const ProgramResult info = multum({"info", path("map.ndf.exr")});
    EXPECT_TRUE(contains(info.out, levels)) << info.out;
    expect_says(info.out, {"besides the normal map"});
    EXPECT_TRUE(contains(info.out, fmt::format("\"first_level\":{}", first_level))) << info.out;
    const std::string table = measured_tables(result.out);
    EXPECT_FALSE(table.empty());
    EXPECT_TRUE(contains(info.out, table)) << "the bake printed\n" << table << "info prints\n" << info.out;
  }
}

TEST_F(BakeCommandTest, EightLobesAndTheNormalMapAreMeasuredTogether) {
  make_map("map", 16);
  const ProgramResult bake = multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--lobes", "8",
                                     "--iterations", "1", "--first-level", "1", "-v"});
  ASSERT_EQ(bake.exit_code, 0) << bake.err;
  EXPECT_TRUE(contains(bake.out, "\n      0       all        0.00 | ")) << "each normal is its own at level 0\n"
                                                                        << bake.out;
}

TEST_F(BakeCommandTest, InfoCountsBytesOnTheGpu) {
  make_map("map", 64);
  ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--no-measure"}).exit_code, 0);
  const ProgramResult info = multum({"info", path("map.ndf.exr")});
  // There are 5461 texels with 4 lobes of 8 bytes each, and 343 blocks of 16 + 8 bytes.
  EXPECT_TRUE(
      contains(info.out, "on the GPU      170.7 KiB, 21.2 times the 8.0 KiB of a BC5 normal and a BC4 roughness\n"))
      << info.out;
}

// Makes two maps of the same noise. One map is an ordinary rough surface. The other map has slopes so slight that only
// a glossy material shows them.
TEST_F(BakeCommandTest, LobesTooSharpForTheStorageAreWarnedOf) {
  const auto bake = [&](double slope, const std::string& storage) {
    TestImage noise{.width = 64, .height = 64};
    noise.type = OIIO::TypeDesc::FLOAT;
    std::mt19937 random(3);
    const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24 * 2.0 - 1.0; };
    for (int i = 0; i < 64 * 64; ++i) {
      const double x = slope * uniform(), y = slope * uniform();
      const glm::dvec3 n = glm::normalize(glm::dvec3(x, y, 1.0));
      for (int c = 0; c < 3; ++c) noise.values.push_back(static_cast<float>(n[c]));
    }
    write_test_image(path("noise.exr"), noise);
    const ProgramResult result =
        multum({"bake", path("noise.exr"), "-o", path("noise.ndf.exr"), "--bumpformat", "normal", "--signed", "--green",
                "up", "--no-measure", "-d", storage, "--report", path("report.json"), "-v"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const auto report = nlohmann::json::parse(read_bytes(path("report.json")));
    const std::uint64_t count = report["counts"]["unrepresentable"];
    const double share = report["unrepresentable_share"];
    EXPECT_EQ(count > 0, share > 0.0);
    EXPECT_LE(share, 1.0);
    EXPECT_TRUE(contains(result.out, fmt::format("{} are too sharp for the data format", count))) << result.out;
    const bool warned = contains(result.err, "warning: ") && contains(result.err, "lose their width");
    EXPECT_EQ(warned, share > 1.0 / 3.0) << share << "\n" << result.err;
    if (warned) {
      EXPECT_TRUE(contains(result.err, fmt::format("noise.exr: {} lobes", count))) << result.err;
      const char* advice = storage == "half" ? "--data-format snorm16 stores" : "--data-format float keeps";
      EXPECT_TRUE(contains(result.err, advice)) << result.err;
    }
    return warned;
  };
  EXPECT_FALSE(bake(0.5, "snorm16"));
  EXPECT_TRUE(bake(0.01, "snorm16"));
  EXPECT_FALSE(bake(0.01, "float"));
  EXPECT_FALSE(bake(0.5, "half"));
  EXPECT_TRUE(bake(0.06, "half"));
}

TEST_F(BakeCommandTest, TheReportHasTimesCountsAndErrors) {
  make_map("map", 64);
  const ProgramResult bake =
      multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--report", path("report.json")});
  ASSERT_EQ(bake.exit_code, 0) << bake.err;
  const auto report = nlohmann::json::parse(read_bytes(path("report.json")));
  std::vector<std::string> stages;
  for (const auto& stage : report["stages"]) {
    stages.push_back(stage["name"]);
    EXPECT_GE(stage["seconds"].get<double>(), 0.0);
  }
  EXPECT_EQ(stages, (std::vector<std::string>{"read", "fit", "measure", "write"}));
  EXPECT_GT(report["start"]["tried"], 1);
  EXPECT_GT(report["binning"]["launches"], 0);
  std::uint64_t launches_of_fit = report["start"]["launches"], launches_of_kernels = 0;
  launches_of_fit += report["binning"]["launches"].get<std::uint64_t>();
  EXPECT_GT(launches_of_fit, 0u);
  ASSERT_EQ(report["levels"].size(), 7u);
  for (int l = 0; l < 7; ++l) {
    const auto& level = report["levels"][static_cast<std::size_t>(l)];
    EXPECT_EQ(level["level"], l);
    EXPECT_EQ(level["width"], 64 >> l);
    EXPECT_EQ(level["height"], 64 >> l);
    EXPECT_GT(level["launches"].get<int>(), 0);
    launches_of_fit += level["launches"].get<std::uint64_t>();
  }
  for (const auto& [kernel, count] : report["launches"].items()) launches_of_kernels += count.get<std::uint64_t>();
  EXPECT_EQ(launches_of_fit + 2, launches_of_kernels)
      << "all launches except for two that measure levels and pixels: those of the start, of binning and of levels";
  EXPECT_EQ(report["counts"]["lobes"], 4 * (4096 + 1024 + 256 + 64 + 16 + 4 + 1));
  EXPECT_EQ(report["counts"]["nonfinite"], 0);
  for (const char* count : {"kappa_clamped", "dead_lobes", "undirected_lobes", "unrepresentable"})
    EXPECT_TRUE(report["counts"][count].is_number_unsigned()) << count;
  for (const char* count : {"unused_texels", "nonfinite_repaired", "zero_length_repaired", "below_horizon_repaired"})
    EXPECT_EQ(report["input"][count], 0) << count;

  const auto row = [&](int level, const std::string& point, const std::string& brdf) {
    return std::count_if(report["measured_error"].begin(), report["measured_error"].end(), [&](const auto& r) {
      const double error = r["relative_l1"];
      return r["level"] == level && r["point"] == point && r["brdf"] == brdf && r["samples"].template get<int>() > 0 &&
             error >= 0.0 && error < 1.0;
    });
  };
  for (int level = 0; level < 7; ++level)
    for (const char* brdf : {"lambert", "blinn-phong:20", "blinn-phong:100", "blinn-phong:500"}) {
      EXPECT_EQ(row(level, "centre", brdf), 1) << level << " " << brdf;
      // The coarsest level has no neighbours.
      for (const char* point : {"midway-x", "midway-y", "between-levels"})
        EXPECT_EQ(row(level, point, brdf), level < 6 ? 1 : 0) << level << " " << point << " " << brdf;
    }
}

TEST_F(BakeCommandTest, RepairsAreShown) {
  TestImage image = normal_image(64, 64);
  for (int c = 0; c < 3; ++c) image.at(9, 9, c) = 128.0f / 255.0f;  // this normal has length 0
  for (int i = 0; i < 128; ++i)
    for (int c = 0; c < 3; ++c) image.at(i % 64, 20 + i / 64, c) = 0.0f;
  write_test_image(path("holes.png"), image);
  const ProgramResult bake =
      multum({"bake", path("holes.png"), "-o", path("holes.ndf.exr"), "--no-measure", "--report", path("report.json")});
  ASSERT_EQ(bake.exit_code, 0) << bake.err;
  expect_says(bake.out, {"0 were not finite", "1 had zero length", "0 were below the horizon", "128 were black"});
  expect_says(bake.err, {"warning: ", path("holes.png"), "128 of 4096 texels", "3.1 %", "black"});
  const auto input = nlohmann::json::parse(read_bytes(path("report.json")))["input"];
  EXPECT_EQ(input["unused_texels"], 128);
  EXPECT_EQ(input["zero_length_repaired"], 1);
  EXPECT_EQ(input["warnings"].size(), 1u);

  write_test_image(path("whole.png"), normal_image(64, 64));
  const ProgramResult whole = multum({"bake", path("whole.png"), "-o", path("whole.ndf.exr"), "--no-measure"});
  EXPECT_FALSE(contains(whole.out, "repaired")) << whole.out;
  EXPECT_FALSE(contains(whole.err, "warning")) << whole.err;
}

TEST_F(BakeCommandTest, DoubtsAreWarnedOf) {
  TestImage heights{.width = 64, .height = 64, .channels = 1};
  for (int i = 0; i < 64 * 64; ++i) heights.values.push_back(static_cast<float>(i % 64) / 63.0f);
  write_test_image(path("heights.png"), heights);
  std::vector<std::string> bake = {"bake",         path("heights.png"), "-o", path("heights.ndf.exr"),
                                   "--no-measure", "--green",           "up"};
  const ProgramResult warned = multum(bake);
  EXPECT_EQ(warned.exit_code, 0) << warned.err;
  expect_says(warned.err,
              {"heights.png: ", "height field", "a height scale of 1", "warning: ", "--green", "no effect"});
  bake.emplace_back("--quiet");
  EXPECT_EQ(multum(bake).err, "");
}

// The warning appears whether the bake is started by a command line, a manifest or a scene.
TEST_F(BakeCommandTest, GreenAgainstTheGradientsIsWarnedOf) {
  write_test_image(path("down.png"), normal_image(64, 64, false, -1.0));
  const auto expect_warned = [](const ProgramResult& result, const std::string& advised = "green = \"down\"") {
    EXPECT_EQ(result.exit_code, 0) << result.err;
    expect_says(result.err, {"warning: ", "down.png", "gradient agreement", advised});
  };
  expect_warned(multum({"bake", path("down.png"), "-o", path("down.ndf.exr"), "--no-measure", "--ndf", "moments",
                        "--green", "up"}),
                "--green down");
  write_bytes(path("maps.toml"),
              "[defaults]\ngreen = \"up\"\nndf = \"moments\"\n[[map]]\ninput = \"down.png\"\n"
              "output = \"listed.ndf.exr\"\n");
  expect_warned(multum({"bake", "--manifest", path("maps.toml")}));
  write_bytes(path("scene.toml"),
              "[[map]]\nname = \"m\"\nnormal = \"down.png\"\ngreen = \"up\"\n[[material]]\nname = \"p\"\nbrdf = "
              "\"lambert\"\n[[object]]\nname = \"o\"\nmap = \"m\"\nmaterial = \"p\"\nwidth = 2.0\ndistance = 2.0\n"
              "[[light]]\ndirection = [0.3, 0.8, 0.5]\n");
  expect_warned(multum({"plan", path("scene.toml"), "-o", path("plan.json")}));
}

// If the bake chooses the wrap modes, the file states the modes that the map's borders suggest. The file also stores
// that the bake chose them.
TEST_F(BakeCommandTest, WrapIsFoundOnRequest) {
  TestImage ramp{.width = 64, .height = 64, .channels = 1};
  for (int i = 0; i < 64 * 64; ++i) ramp.values.push_back(static_cast<float>(i % 64) / 63.0f);
  write_test_image(path("ramp.png"), ramp);
  const std::vector<std::string> bake = {
      "bake",   path("ramp.png"), "-o", path("ramp.ndf.exr"), "--no-measure", "--bumpformat",
      "height", "--height-scale", "30"};
  const ProgramResult warned = multum(bake);
  EXPECT_EQ(warned.exit_code, 0) << warned.err;
  expect_says(warned.err, {"warning: ", "s (x)", "--swrap"});
  EXPECT_FALSE(contains(warned.err, "--twrap")) << warned.err;
  std::vector<std::string> by_itself = bake;
  by_itself.insert(by_itself.end(), {"--wrap", "auto"});
  const ProgramResult found = multum(by_itself);
  EXPECT_EQ(found.exit_code, 0) << found.err;
  EXPECT_FALSE(contains(found.err, "warning: ")) << found.err;
  expect_says(multum({"info", path("ramp.ndf.exr")}).out, {"wrap clamp, periodic", "\"wrap\":\"auto,auto\""});
  EXPECT_TRUE(contains(multum(by_itself).out, "ramp.ndf.exr: unchanged")) << "the same settings";

  write_bytes(path("maps.toml"),
              "[[map]]\ninput = \"ramp.png\"\nbumpformat = \"height\"\nheight_scale = 30\nndf = "
              "\"moments\"\nwrap = \"auto\"\noutput = \"listed.ndf.exr\"\n");
  const ProgramResult listed = multum({"bake", "--manifest", path("maps.toml")});
  EXPECT_EQ(listed.exit_code, 0) << listed.err;
  expect_says(multum({"info", path("listed.ndf.exr")}).out, {"wrap clamp, periodic"});
  write_bytes(path("scene.toml"),
              "[[map]]\nname = \"m\"\nnormal = \"ramp.png\"\nbumpformat = \"height\"\nheight_scale = 30\nwrap = "
              "\"auto\"\n[[material]]\nname = \"p\"\nbrdf = \"blinn-phong\"\nexponent = 100\n[[object]]\nname = "
              "\"o\"\nmap = \"m\"\nmaterial = \"p\"\nwidth = 2.0\ndistance = 2.0\n[[light]]\ndirection = [0.3, "
              "0.8, 0.5]\n");
  const ProgramResult scene = multum({"bake", path("scene.toml"), "-o", path("scene")});
  EXPECT_EQ(scene.exit_code, 0) << scene.err;
  expect_says(multum({"info", path("scene/m.ndf.exr")}).out, {"wrap clamp, periodic"});
}

// Texels without a colour are counted like repaired normals, on the terminal and in the report.
TEST_F(BakeCommandTest, TexelsWithoutAColourAreCounted) {
  write_test_image(path("map.png"), normal_image(32, 32));
  TestImage albedo{.width = 32, .height = 32, .type = OIIO::TypeDesc::FLOAT};
  albedo.values.assign(32 * 32 * 3, 0.5f);
  albedo.at(3, 4, 0) = kNan;
  albedo.at(5, 6, 1) = -0.25f;
  albedo.at(7, 8, 2) = kInf;
  write_test_image(path("albedo.exr"), albedo);
  const ProgramResult bake = multum({"bake", path("map.png"), "--albedo", path("albedo.exr"), "-o", path("map.ndf.exr"),
                                     "--ndf", "moments", "--no-measure", "--report", path("map.json")});
  EXPECT_EQ(bake.exit_code, 0) << bake.err;
  expect_says(bake.out, {"3 albedo texels", "read as 0"});
  EXPECT_EQ(nlohmann::json::parse(read_bytes(path("map.json")))["albedo_clamped"], 3);
}

TEST_F(BakeCommandTest, ColoursThatHalfsCannotHoldAreRefused) {
  write_test_image(path("map.png"), normal_image(32, 32));
  const auto bake = [&](float value, const char* type) {
    TestImage albedo{.width = 32, .height = 32, .type = OIIO::TypeDesc::FLOAT};
    albedo.values.assign(32 * 32 * 3, 0.5f);
    albedo.at(3, 4, 1) = value;
    write_test_image(path("albedo.exr"), albedo);
    std::filesystem::remove(path("map.ndf.exr"));
    return multum({"bake", path("map.png"), "--albedo", path("albedo.exr"), "-o", path("map.ndf.exr"), "-d", type,
                   "--report", path("map.json")});
  };
  for (const char* type : {"snorm16", "half"}) {
    const ProgramResult refused = bake(65536.0f, type);
    EXPECT_EQ(refused.exit_code, exit_code(ErrorCode::kInput));
    expect_says(refused.err, {path("albedo.exr"), "65536", "65504", "--data-format float"});
    EXPECT_FALSE(std::filesystem::exists(path("map.ndf.exr")));
  }
  for (const auto& [value, type] : {std::pair{65504.0f, "snorm16"}, std::pair{1e14f, "float"}}) {
    const ProgramResult baked = bake(value, type);
    EXPECT_EQ(baked.exit_code, 0) << baked.err;
    EXPECT_EQ(multum({"verify", path("map.ndf.exr")}).exit_code, 0);
    EXPECT_EQ(read_bytes(path("map.json")).find("null"), std::string::npos) << value << " " << type;
  }
  EXPECT_EQ(bake(1e16f, "float").exit_code, exit_code(ErrorCode::kInput));
}

// None of the measured directions sees the highlight, so the absolute error is small. The relative error must still
// make sense.
TEST_F(BakeCommandTest, AMapTiltedFarHasErrorsThatSaySomething) {
  TestImage map{.width = 32, .height = 32};
  for (int i = 0; i < 32 * 32; ++i) map.values.insert(map.values.end(), {0.9924f, 0.5f, 0.5868f});
  write_test_image(path("map.png"), map);
  const ProgramResult bake = multum({"bake", path("map.png"), "-o", path("map.ndf.exr"), "--report", path("map.json")});
  EXPECT_EQ(bake.exit_code, 0) << bake.err;
  const nlohmann::json report = nlohmann::json::parse(read_bytes(path("map.json")));
  ASSERT_FALSE(report["measured_error"].empty());
  for (const nlohmann::json& row : report["measured_error"]) EXPECT_LT(row["relative_l1"].get<double>(), 0.01) << row;
}

TEST_F(BakeCommandTest, TestmapSaysItsGreenAndABakeDetectsIt) {
  for (const auto& [green, words] : {std::pair{"up", "up (OpenGL)"}, std::pair{"down", "down (DirectX)"}}) {
    const ProgramResult made = multum({"testmap", path(green), "--size", "64", "--write-green", green});
    expect_says(made.out, {"green points ", words});
    const ProgramResult bake =
        multum({"bake", path(std::string(green) + "_normal.png"), "-o", path("map.ndf.exr"), "--no-measure"});
    expect_says(bake.err, {std::string("green ") + words});
    EXPECT_FALSE(contains(bake.err, "warning")) << bake.err;
  }
}

TEST_F(BakeCommandTest, TheProgressBarIsForTerminalsAlone) {
  make_map("map", 512);  // The bar is redrawn after a twelfth of a second, which is less than a fit takes.
  const std::vector<std::string> arguments = {"bake",    path("map_normal.png"), "-o", path("map.ndf.exr"),
                                              "--force", "--no-measure"};
  const ProgramResult piped = multum(arguments);
  ASSERT_EQ(piped.exit_code, 0) << piped.err;
  for (const std::string& text : {piped.out, piped.err}) {
    EXPECT_EQ(text.find_first_of("\r\033"), std::string::npos) << text;
    EXPECT_TRUE(!text.empty() && text.back() == '\n') << text;
  }
  if (!has_pseudo_terminals()) GTEST_SKIP() << "there are no pseudo terminals; only pipes were tested";
  const ProgramResult shown = run_on_terminal(multum_command(arguments));
  ASSERT_EQ(shown.exit_code, 0) << shown.out;
  for (const char* part : {"\r\033[K[", "%", "fit level ", "map.ndf.exr: written"})
    EXPECT_TRUE(contains(shown.out, part)) << part;
  EXPECT_GT(shown.out.find("written"), shown.out.rfind('[')) << "the bar is gone before the result is printed";

  std::vector<std::string> quiet = arguments;
  quiet.emplace_back("--quiet");
  const ProgramResult silent = run_on_terminal(multum_command(quiet));
  EXPECT_EQ(silent.exit_code, 0);
  EXPECT_EQ(silent.out, "");
}

TEST_F(BakeCommandTest, RunstatsPrintLevelsAndLaunches) {
  make_map("map", 64);
  const ProgramResult bake =
      multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--runstats", "--no-measure"});
  ASSERT_EQ(bake.exit_code, 0) << bake.err;
  for (const char* part : {"level  0      64 x 64", "level  6       1 x 1", "movmf_em_texels ", "movmf_start "})
    EXPECT_TRUE(contains(bake.out, part)) << part << " is not in\n" << bake.out;
}

// This test has its own cache; the other tests share one.
TEST_F(BakeCommandTest, ProgramsAreKeptInTheCacheFolder) {
  make_map("map", 16);
  setenv("MULTUM_CACHE_DIR", path("cache").c_str(), 1);
  const auto bake = [&] {
    return multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--ndf", "moments", "--no-measure",
                   "--force", "--verbose"});
  };
  const ProgramResult first = bake();
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_FALSE(contains(first.err, " loaded")) << first.err;
  EXPECT_TRUE(contains(first.err, "compiling kernels for ")) << first.err;
  EXPECT_FALSE(std::filesystem::is_empty(path("cache")));
  const std::string bytes = read_bytes(path("map.ndf.exr"));
  const ProgramResult second = bake();
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_TRUE(contains(second.err, "program cache: mip_box loaded")) << second.err;
  EXPECT_TRUE(read_bytes(path("map.ndf.exr")) == bytes);
}

TEST_F(BakeCommandTest, WhatIsBakedAlreadyIsNotBakedAgain) {
  make_map("map", 32);
  const std::string output = path("map.ndf.exr"), report = path("report.json");
  // Returns whether the map was baked, that is, whether the file was replaced.
  const auto bakes = [&](std::vector<std::string> options) {
    const auto before = std::filesystem::exists(output) ? std::filesystem::last_write_time(output)
                                                        : std::filesystem::file_time_type::min();
    options.insert(options.begin(), {"bake", path("map_normal.png"), "-o", output, "--report", report});
    const ProgramResult result = multum(options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const bool baked = std::filesystem::last_write_time(output) != before;
    EXPECT_EQ(contains(result.out, "map.ndf.exr: unchanged"), !baked) << result.out;
    EXPECT_EQ(nlohmann::json::parse(read_bytes(report))["unchanged"], !baked);
    return baked;
  };
  EXPECT_TRUE(bakes({"--no-measure"}));
  EXPECT_FALSE(bakes({"--no-measure"}));
  EXPECT_FALSE(bakes({"--no-measure", "--threads", "1"})) << "threads do not change the file";
  EXPECT_TRUE(bakes({"--no-measure", "--force"}));
  EXPECT_TRUE(bakes({})) << "the file had no measured error";
  EXPECT_FALSE(bakes({}));
  EXPECT_FALSE(bakes({"--no-measure"})) << "the file has more data than requested";
  for (const auto& [option, value] : {std::pair("--lobes", "2"), std::pair("--compression", "rle"),
                                      std::pair("--wrap", "clamp"), std::pair("-d", "half")}) {
    EXPECT_TRUE(bakes({option, value})) << option;
    EXPECT_FALSE(bakes({option, value})) << option;
  }
  EXPECT_TRUE(bakes({}));
  const std::string map = read_bytes(path("map_normal.png"));
  make_map("map", 64);
  EXPECT_TRUE(bakes({})) << "the map has changed";
  write_bytes(path("map_normal.png"), map);
  write_bytes(output, "no baked file");
  EXPECT_TRUE(bakes({}));
}

TEST_F(BakeCommandTest, SetsAreBakedTileByTile) {
  make_map("map", 32);
  std::filesystem::copy(path("map_normal.png"), path("rock_1001.png"));
  write_bytes(path("rock_1002.png"), "no picture");
  std::filesystem::copy(path("map_normal.png"), path("rock_1012.png"));
  const ProgramResult result = multum({"bake", path("rock_<UDIM>.png"), "-o", path("rock_<UDIM>.ndf.exr"), "--report",
                                       path("rock_<UDIM>.json"), "--no-measure"});
  EXPECT_EQ(result.exit_code, 3) << "the broken tile's";
  expect_says(result.err, {"rock_1002.png", "3 maps", "2 baked", "0 unchanged", "1 failed"});
  EXPECT_FALSE(std::filesystem::exists(path("rock_1002.ndf.exr")));
  ASSERT_EQ(
      multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--no-measure", "--report", path("map.json")})
          .exit_code,
      0);
  for (const char* tile : {"rock_1001", "rock_1012"}) {
    EXPECT_EQ(multum({"verify", path(tile + std::string(".ndf.exr"))}).exit_code, 0);
    EXPECT_EQ(read_movmf_mipmap(path(tile + std::string(".ndf.exr"))).header.provenance.content_hash,
              read_movmf_mipmap(path("map.ndf.exr")).header.provenance.content_hash)
        << "the same bytes as a separate bake";
    EXPECT_EQ(nlohmann::json::parse(read_bytes(path(tile + std::string(".json"))))["launches"],
              nlohmann::json::parse(read_bytes(path("map.json")))["launches"])
        << "each report counts its own launches";
  }
  const ProgramResult again = multum({"bake", path("rock_1001.png"), path("rock_1012.png"), "-o", path(""), "-q"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
}

// A bake that is divided into shares gives the same bytes as a single run. A tile is baked again if the border of a
// neighbouring tile has changed.
TEST_F(BakeCommandTest, TilesOfHeightsTakeTheBordersOfOthers) {
  const auto write_tile = [&](const std::string& tile, int x0, int changed_column) {
    TestImage image{.width = 32, .height = 32, .channels = 1, .type = OIIO::TypeDesc::UINT16};
    for (int i = 0; i < 32 * 32; ++i)
      image.values.push_back(static_cast<float>(
          i % 32 == changed_column ? 0.6 : 0.5 + 0.2 * std::sin(0.1 * (x0 + i % 32) + 0.15 * (i / 32))));
    write_test_image(path("h_" + tile + ".png"), image);
  };
  write_tile("1001", 0, -1);
  write_tile("1002", 32, -1);
  write_tile("1003", 64, -1);
  const auto bake = [&](const std::string& folder, std::vector<std::string> more) {
    std::filesystem::create_directories(path(folder));
    more.insert(more.begin(), {"bake", path("h_%(UDIM)d.png"), "-o", path(folder + "/h_<UDIM>.ndf.exr"), "--bumpformat",
                               "height", "--height-scale", "30", "--wrap", "clamp", "--lobes", "2", "--no-measure"});
    const ProgramResult result = multum(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out + result.err;
  };
  bake("a", {});
  for (const char* share : {"1/3", "2/3", "3/3"}) bake("b", {"--shard", share});
  for (const char* tile : {"1001", "1002", "1003"})
    EXPECT_TRUE(read_bytes(path("a/h_" + std::string(tile) + ".ndf.exr")) ==
                read_bytes(path("b/h_" + std::string(tile) + ".ndf.exr")))
        << tile;
  expect_says(bake("a", {}), {"0 baked, 3 unchanged"});
  write_tile("1002", 32, 15);
  expect_says(bake("a", {}), {"1 baked, 2 unchanged"});
  write_tile("1002", 32, 0);
  expect_says(bake("a", {}), {"2 baked, 1 unchanged"});
  const BakedProvenance from = read_movmf_mipmap(path("a/h_1001.ndf.exr")).header.provenance;
  EXPECT_EQ(from.file_hash(), hash_file(path("h_1001.png")));
  EXPECT_NE(from.source_hash, from.file_hash());
}

TEST_F(BakeCommandTest, ThreadsAndRepetitionDoNotChangeAByte) {
  make_map("map", 64);
  const auto bake = [&](const std::string& name, std::vector<std::string> options) {
    options.insert(options.begin(),
                   {"bake", path("map_normal.png"), "--albedo", path("map_albedo.png"), "-o", path(name), "--quiet"});
    const ProgramResult result = multum(options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_bytes(path(name));
  };
  const std::string once = bake("a.ndf.exr", {"--threads", "2"});
  EXPECT_TRUE(once == bake("b.ndf.exr", {"--threads", "2"})) << "a second run differs";
  EXPECT_TRUE(once == bake("c.ndf.exr", {"--threads", "1"})) << "one thread differs from two";
  EXPECT_TRUE(once == bake("d.ndf.exr", {"--threads", "5"})) << "five threads differ from two";
  // The header does not name the kernel variant, so the whole file is the same.
  EXPECT_TRUE(once == bake("e.ndf.exr", {"--scalar"})) << "the scalar kernels differ from the vector kernels";
  const std::string reference = bake("reference.ndf.exr", {"--reference"});
  EXPECT_FALSE(once == reference);
  EXPECT_TRUE(reference == bake("g.ndf.exr", {"--reference", "--threads", "1"}))
      << "--reference: one thread differs from two";
  EXPECT_TRUE(reference == bake("h.ndf.exr", {"--reference", "--scalar"})) << "--reference: the scalar kernels differ";
  EXPECT_FALSE(once == bake("f.ndf.exr", {"--iterations", "29"})) << "a setting is without effect";
}

// Returns the peak of the Blinn-Phong highlight with s = 2 / alpha^2 - 2 on stored lobes, which are shaded as
// docs/reference/file_format.md says. The lobes of a flat texel have the same direction except for rounding, so the
// peak is at the mean normal.
double highlight_peak(const std::vector<glm::dvec4>& lobes, double exponent) {
  const double cosine = (exponent + 1.0) / (exponent + 2.0);
  glm::dvec3 at(0.0);
  for (const glm::dvec4& lobe : lobes) at += glm::dvec3(lobe);
  at = glm::normalize(at);
  double value = 0.0;
  for (const glm::dvec4& lobe : lobes) {
    if (lobe.w <= 0.0) continue;
    const double length = glm::length(glm::dvec3(lobe));
    const double kappa = 1.0 / (1.0 - std::min(length / lobe.w, 1.0) * cosine);
    value +=
        lobe.w * kappa / (2.0 * std::numbers::pi) * std::exp(kappa * (glm::dot(glm::dvec3(lobe) / length, at) - 1.0));
  }
  return value;
}

TEST_F(BakeCommandTest, AFileKeepsTheHighlightOfGlossyTiltedFlats) {
  constexpr double kAlpha = 0.01;  // alpha of roughness 0.1
  constexpr double kExponent = 2.0 / (kAlpha * kAlpha) - 2.0;
  const double exact = highlight_peak({{0.0, 0.0, 1.0, 1.0}}, kExponent);
  double worst = 0.0;
  for (int tilt = 0; tilt <= 60; tilt += 10) {
    const double t = tilt * std::numbers::pi / 180.0, azimuth = 0.3 + 0.9 * tilt;
    TestImage flat{.width = 16, .height = 16};
    flat.type = OIIO::TypeDesc::FLOAT;
    for (int i = 0; i < 256; ++i)
      for (const double v : {std::sin(t) * std::cos(azimuth), std::sin(t) * std::sin(azimuth), std::cos(t)})
        flat.values.push_back(static_cast<float>(v));
    write_test_image(path("flat.exr"), flat);
    const ProgramResult bake = multum({"bake", path("flat.exr"), "-o", path("flat.ndf.exr"), "--bumpformat", "normal",
                                       "--signed", "--green", "up", "--no-measure", "--quiet"});
    ASSERT_EQ(bake.exit_code, 0) << bake.err;
    const MovmfMipmap mipmap = read_movmf_mipmap(path("flat.ndf.exr"));
    ASSERT_EQ(mipmap.header.encoding, StorageEncoding::kSnorm16) << "the default";
    for (const MovmfLevel& level : mipmap.levels)
      for (std::size_t i = 0; i < level.lobes[0].size(); ++i) {
        std::vector<glm::dvec4> lobes;
        for (const auto& lobe : level.lobes) lobes.emplace_back(lobe[i]);
        worst = std::max(worst, std::abs(highlight_peak(lobes, kExponent) / exact - 1.0));
      }
  }
  std::printf("  the peak changes by at most %.2f %%\n", worst * 100.0);
  EXPECT_LE(worst, 0.02);
}

TEST_F(BakeCommandTest, HelpShowsNamesAndDefaults) {
  const ProgramResult help = multum({"bake", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  const std::pair<const char*, const char*> values_and_defaults[] = {
      {"{snorm16,half,float}", "snorm16"},
      {"{colour,scanline}", "colour"},
      {"{auto,height,normal,packed16,packed24,terrarium,mapbox}", "auto"},
      {"{none,black,box3}", "box3"},
      {"--lobes INT in [1, 8]", "4"},
      {"--compression none|rle|piz|zip[:1-9]|zips[:1-9]", "zip:1"},
      {"--first-level INT in [0, 15]", "0"}};
  for (const auto& [values, usual] : values_and_defaults)  // versions of CLI11 write defaults in two ways
    EXPECT_TRUE(contains(help.out, fmt::format("{}={}", values, usual)) ||
                contains(help.out, fmt::format("{} [{}]", values, usual)))
        << values << ", default " << usual << " is not in\n"
        << help.out;
  for (const char* part :
       {"{auto,black,clamp,periodic,mirror}", "PNG, TIFF, EXR, JPEG or WebP, up to 32768 texels per side"})
    EXPECT_TRUE(contains(help.out, part)) << part << " is not in\n" << help.out;
  for (const char* part : {"->", "ENUM"}) EXPECT_FALSE(contains(help.out, part)) << part;
}

TEST_F(BakeCommandTest, ChoicesTakeEffect) {
  make_map("map", 16);
  for (const auto& [option, name, setting] : std::vector<std::tuple<std::string, std::string, std::string>>{
           {"--data-format", "half", "\"encoding\":\"half\""},
           {"-d", "float", "\"encoding\":\"float\""},
           {"-d", "snorm16", "\"encoding\":\"snorm16\""},
           {"--order", "scanline", "\"order\":\"scanline\""},
           {"--bumpformat", "normal", "\"bump_format\":\"normal\""},
           {"--fixnan", "black", "\"fixnan\":\"black\""}}) {
    const ProgramResult bake = multum(
        {"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--no-measure", "--iterations", "1", option, name});
    ASSERT_EQ(bake.exit_code, 0) << bake.err;
    EXPECT_TRUE(contains(multum({"info", path("map.ndf.exr")}).out, setting)) << setting;
  }
}

}  // namespace
}  // namespace multum::testing
