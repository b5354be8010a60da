// SPDX-License-Identifier: Apache-2.0
// Tests the refusals and warnings of multum-view: exit codes and messages. Each output file must be either complete or
// absent.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/image/files/png_writer.h"
#include "host/formats/image/normals/reading_settings.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/processes/child_process.h"
#include "tests/gl/sh_test_map.h"
#include "tests/gl/test_maps.h"
#include "tests/gl/view/view_test_fixture.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

class ViewRefusalTest : public testing::ViewTest {};

TEST_F(ViewRefusalTest, RefusesWhatIsForAnotherRepresentation) {
  expect_refusal({"-o", path("out.png"), "--moments", "lean"}, 2, {"map.ndf.exr", "holds lobes", "--moments"});
  expect_refusal({"-o", path("out.png"), "--moments", "leen"}, 2, {"--moments"});
  write_moment_mipmap(path("map.ndf.exr"), gl::make_moments(gl::make_flat_map(8).image, StorageEncoding::kHalf), {});
  expect_refusal({"-o", path("out.png"), "--formula", "paper"}, 2, {"holds moments", "--formula paper"});
  write_sh_mipmap(path("map.ndf.exr"), gl::make_harmonics(gl::make_flat_map(8).image, 2, StorageEncoding::kHalf), {});
  expect_refusal({"-o", path("out.png"), "--formula", "paper"}, 2, {"spherical harmonics", "--formula paper"});
  expect_refusal({"-o", path("out.png"), "--moments", "lean"}, 2, {"spherical harmonics", "--moments"});
  expect_refusal({"-o", path("out.png"), "--environment", path("sky.hdr"), "--environment-mode", "prefiltered"}, 2,
                 {"spherical harmonics", "--environment-mode prefiltered, expected sh"});
  expect_refusal({"-o", path("out.png"), "--compare", "leen"}, 2, {"reference, mip, toksvig, lean, lean-jacobian"});
}

TEST_F(ViewRefusalTest, WarnsWhereTheRendererFiltersAnisotropicallyWrong) {
  const std::vector<std::string> arguments = {"-o", path("out.png"), "--size", "32x24", "--anisotropy",
                                              "4",  "--context",     "osmesa"};
  EXPECT_EQ(view(arguments).output.find("--anisotropy"), std::string::npos) << "16 x 16 is filtered right";
  gl::TestMap map = gl::make_two_tilt_map(12, 20.0, StorageEncoding::kSnorm16, false);
  write_movmf_mipmap(path("map.ndf.exr"), map.mipmap, {});
  const ChildResult result = view(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  testing::expect_says(result.output, {"map.ndf.exr: ", "12 x 12"});
}

TEST_F(ViewRefusalTest, WrongCommandLinesAreUsageErrors) {
  const std::string out = path("out.png");
  expect_refusal({"-o", path("out.jpg")}, 2, {"out.jpg", ".png or .exr"});
  expect_refusal({}, 2, {"multum-view: ", "--output", "required", "multum-view --help"});
  expect_refusal({"-o", out, "--brdf", "ggx:0.01"}, 2, {"ggx:ROUGHNESS"});
  expect_refusal({"-o", out, "--brdf", "blinn-phong:nan"}, 2, {"blinn-phong:S"});
  expect_refusal({"-o", out, "--brdf", "blinn-phong:0"}, 2, {"1..100000"});
  expect_refusal({"-o", out, "--brdf", "charlie:0.04"}, 2, {"charlie:ROUGHNESS with ROUGHNESS 0.05..1"});
  expect_refusal({"-o", out, "--brdf", "charlie:0.3", "--environment", path("sky.hdr")}, 2,
                 {"--brdf: found charlie:0.3 with an environment", "expected only lights, or another BRDF"});
  expect_refusal({"-o", out, "--brdf", "ggx:0.3,1.5"}, 2, {"F0 0..1"});
  expect_refusal({"-o", out, "--brdf", "cook-torrance:0.3,0.1,0.2"}, 2, {"cook-torrance:SIGMA"});
  expect_refusal({"-o", out, "--brdf", path("map.ndf.exr")}, 3, {"not a measured BRDF"});
  expect_refusal({"-o", out, "--brdf-terms", "5"}, 2, {"--brdf-terms"});
  expect_refusal({"-o", out, "--point-light", "0,0,1"}, 2, {"--point-light", "intensity"});
  expect_refusal({"-o", out, "--point-light", "0,0,1,-1"}, 2, {"--point-light", "intensity"});
  expect_refusal({"-o", out, "--environment", path("map.ndf.exr")}, 3,
                 {"map.ndf.exr", "multum baked from", "expected a map"});
  expect_refusal({"-o", out, "--light", "0,0,0"}, 2, {"--light", "towards"});
  expect_refusal({"-o", out, "--light", "1,2"}, 2, {"--light", "towards"});
  expect_refusal({"-o", out, "--camera", "0,0,0,0,0,0"}, 2, {"eye x,y,z"});
  for (const char* number : {"nan", "inf", "0", "-1", "1e7", "x"})
    for (const char* option : {"--exposure", "--repeat", "--anisotropy", "--reference-noise"})
      expect_refusal({"-o", out, option, number}, 2, {option});
  expect_refusal({"-o", out, "--up", "0,0,0"}, 2, {"--up"});
  expect_refusal({"-o", out, "--up", "0,1"}, 2, {"--up"});
  expect_refusal({"-o", out, "--camera", "0,0,0,1,1,0", "--up", "2,2,0"}, 2, {"line of sight"});
  expect_refusal({"-o", out, "--size", "640x"}, 2, {"WIDTHxHEIGHT"});
  expect_refusal({"-o", out, "--compare", "reference,leaan"}, 2, {"reference, mip, toksvig, lean"});
  expect_refusal({"-o", out, "--context", "glx"}, 2, {"--context"});
  expect_refusal({"-o", out, "--albedo", "a.png"}, 2, {"--source"});
  expect_refusal({"-o", out, "--samples", "0"}, 2, {"--samples"});
  expect_refusal({"-o", out, "--taps", "17"}, 2, {"--taps"});
  expect_refusal({"-o", out, "--taps", "2", "--anisotropy", "2"}, 2, {"--taps", "--anisotropy"});
  expect_refusal({"-o", out, "--samples", "2", "--reference-noise", "0.1"}, 2, {"--samples", "--reference-noise"});
  expect_refusal({"-o", out, "--reference-of", "texels", "--anisotropy", "2"}, 2, {"--reference-of", "--anisotropy"});
}

TEST_F(ViewRefusalTest, UnusableFilesAreInputErrors) {
  const std::string out = path("out.png");
  expect_refusal({"-o", out, "--mesh", path("none.obj")}, 3, {"none.obj"});
  expect_refusal({"-o", out, "--compare", "reference", "--source", path("none.png")}, 3, {"none.png"});
  write_text_file(path("map.ndf.exr"), "not an image");
  expect_refusal({"-o", out}, 3, {"map.ndf.exr"});
}

TEST_F(ViewRefusalTest, ImpossiblePicturesAreEnvironmentErrors) {
  expect_refusal({"-o", path("out.png"), "--size", "1000000x4", "--context", "osmesa"}, 4, {"1000000 x 4"});
  expect_refusal({"-o", "/proc/no/folder/out.png", "--size", "8x8", "--context", "osmesa"}, 4, {"/proc/no"});
}

TEST_F(ViewRefusalTest, OutputsOverwriteNeitherInputsNorEachOther) {
  const std::string out = path("out.png"), baked = path("map.ndf.exr");
  for (const char* name : {"source.png", "albedo.png", "mesh.obj"}) write_text_file(path(name), "as it was");
  const std::vector<std::string> inputs = {"--source",  path("source.png"), "--albedo", path("albedo.png"),
                                           "--mesh",    path("mesh.obj"),   "--size",   "8x8",
                                           "--compare", "reference,mip"};
  const auto refuse = [&](std::vector<std::string> outputs) {
    outputs.insert(outputs.end(), inputs.begin(), inputs.end());
    expect_refusal(outputs, 2, {"twice"});
  };
  const auto size = fs::file_size(baked);
  refuse({"-o", baked});
  refuse({"-o", (folder_ / "." / "map.ndf.exr").string()});
  fs::create_symlink(baked, path("link.exr"));
  refuse({"-o", path("link.exr")});
  refuse({"-o", path("source.png")});
  refuse({"-o", path("albedo.png")});
  refuse({"-o", out, "--report", path("mesh.obj")});
  refuse({"-o", out, "--report", out});
  refuse({"-o", path("one_multum.png"), "--pictures", path("one")});
  fs::rename(path("source.png"), path("one_mip_difference.png"));
  expect_refusal(
      {"-o", out, "--pictures", path("one"), "--source", path("one_mip_difference.png"), "--compare", "mip,reference"},
      2, {"one_mip_difference.png", "twice"});
  EXPECT_EQ(fs::file_size(baked), size);
  for (const char* name : {"one_mip_difference.png", "albedo.png", "mesh.obj"})
    EXPECT_EQ(fs::file_size(path(name)), 9u);
}

TEST_F(ViewRefusalTest, NoPictureIsLeftWhereTheReportCannotBeWritten) {
  expect_refusal({"-o", path("out.png"), "--size", "8x8", "--report", "/proc/no/folder/r.json"}, 4, {"/proc/no"});
  expect_refusal({"-o", path("out.png"), "--size", "8x8", "--report", folder_.string()}, 2, {"is a folder"});
  expect_refusal({"-o", path("out.png"), "--size", "8x8", "--pictures", "/proc/no/folder/p"}, 4, {"/proc/no"});
}

TEST_F(ViewRefusalTest, SourceIsReadAsTheBakeReadIt) {
  // The slopes of a ramp depend on the height scale. At the border, they also depend on the wrap mode.
  constexpr int kSize = 16;
  const auto write_heights = [&](double power) {
    std::vector<std::uint16_t> rgb;
    for (int i = 0; i < kSize * kSize; ++i)
      rgb.insert(rgb.end(), 3, static_cast<std::uint16_t>(65535.0 * std::pow((i % kSize) / (kSize - 1.0), power)));
    write_png16(path("h.png"), kSize, kSize, rgb, "");
  };
  write_heights(2.0);
  NormalMapSettings settings;
  settings.bump_format = BumpFormat::kHeight;
  settings.height_scale = 6.0f;
  settings.wrap_s = WrapMode::kClamp;
  settings.wrap_t = WrapMode::kMirror;
  const NormalMap read = read_normal_map(path("h.png"), settings, 1, nullptr);
  gl::NormalImage image{kSize, kSize, {}, {}, settings.wrap_s, settings.wrap_t};
  for (std::size_t i = 0; i < read.x.size(); ++i) image.normals.emplace_back(read.x[i], read.y[i], read.z[i]);
  MovmfMipmap baked = gl::make_one_lobe_map(image).mipmap;
  nlohmann::json json;
  add_reading_settings(settings, json);
  baked.header.provenance.settings = json.dump();
  baked.header.provenance.source_hash = hash_file(path("h.png"));
  write_movmf_mipmap(path("map.ndf.exr"), baked, {});
  // The view is from above and near, which magnifies texels. The only remaining error is at the borders between texels.
  const auto error = [&](const std::vector<std::string>& more, bool warns) {
    std::vector<std::string> arguments = {
        "-o",       path("out.png"),  "--compare", "reference", "--size",   "64x48",        "--samples", "16",
        "--camera", "0,30,60,0,30,0", "--repeat",  "1",         "--report", path("r.json"), "--context", "osmesa"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_EQ(result.output.find("is not the file") != std::string::npos, warns) << result.output;
    std::ifstream file(path("r.json"));
    return nlohmann::json::parse(file)["pictures"][1]["relative_l1"].get<double>();
  };
  const double own = error({}, false);
  EXPECT_NEAR(error({"--source", path("h.png")}, false), own, 1e-4);
  EXPECT_GT(error({"--source", path("h.png"), "--height-scale", "-6"}, false), own + 0.1);
  EXPECT_GT(error({"--source", path("h.png"), "--bumpformat", "height", "--height-scale", "1"}, false), own + 0.1);
  write_heights(1.0);
  error({"--source", path("h.png")}, true);
}

TEST_F(ViewRefusalTest, NamesGivenTwiceAreDrawnOnce) {
  const ChildResult result = view({"-o", path("out.png"), "--compare", "mip,reference,mip,reference", "--size", "8x8",
                                   "--samples", "1", "--report", path("r.json"), "--context", "osmesa"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  std::ifstream file(path("r.json"));
  EXPECT_EQ(nlohmann::json::parse(file)["pictures"].size(), 3u);
}

TEST_F(ViewRefusalTest, WarnsOfASourceThatIsNotRead) {
  const ChildResult result = view({"-o", path("out.png"), "--source", path("none.png"), "--albedo", path("no.png"),
                                   "--size", "8x8", "--context", "osmesa"});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("none.png: is not read, because no picture needs it without --compare"),
            std::string::npos)
      << result.output;
}

TEST_F(ViewRefusalTest, LinksNeitherGlNorOpenCl) {
  // Lists only the libraries that the program itself names. Image libraries may load more libraries. For example,
  // OpenCV may load OpenCL.
  const ChildResult needed = run_child({"readelf", "-d", std::string(MULTUM_BIN_DIR) + "/multum-view"});
  ASSERT_EQ(needed.exit_code, 0);
  // Shows that readelf printed the list.
  EXPECT_NE(needed.output.find("libOpenEXR"), std::string::npos) << needed.output;
  for (const char* library : {"libOpenCL", "libGL", "libEGL", "libOSMesa", "libOpenGL"})
    EXPECT_EQ(needed.output.find(library), std::string::npos) << library;
}

}  // namespace
}  // namespace multum
