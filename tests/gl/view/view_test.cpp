// SPDX-License-Identifier: Apache-2.0
// Tests multum-view as its users call it: pictures, reports and animations.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/image/colour_map.h"
#include "host/formats/image/files/png_writer.h"
#include "host/formats/image/material_maps.h"
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
using testing::ViewTest;

TEST_F(ViewTest, WritesPictureAndReport) {
  const ChildResult result = view({"-o", path("out.png"), "--compare", "reference,mip,toksvig,lean", "--size", "64x48",
                                   "--samples", "4", "--report", path("r.json"), "--context", "osmesa"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_GT(fs::file_size(path("out.png")), 1000u);
  std::ifstream file(path("r.json"));
  const auto report = nlohmann::json::parse(file);
  ASSERT_EQ(report["pictures"].size(), 5u);
  EXPECT_EQ(report["pictures"][0]["name"], "reference");
  EXPECT_GT(report["pictures"][1]["relative_l1"].get<double>(), 0.0);
}

// By default, a reference takes as many samples as its noise requires. The report states the number of samples and the
// filter.
TEST_F(ViewTest, SaysHowNoisyAReferenceIsAndHowItFilters) {
  const std::vector<std::string> common = {"-o",       path("out.png"), "--compare", "reference", "--size",   "64x48",
                                           "--report", path("r.json"),  "--context", "osmesa",    "--repeat", "60"};
  const auto report_of = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = common;
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    testing::expect_says(result.output, {"samples per pixel", "noise"});
    std::ifstream file(path("r.json"));
    return nlohmann::json::parse(file);
  };
  const nlohmann::json plain = report_of({"--reference-noise", "0.02"});
  EXPECT_EQ(plain["filter"], (nlohmann::json{{"of", "multum"},
                                             {"taps", kTapCountDefault},
                                             {"level_bias", kLevelBiasDefault},
                                             {"shades_taps", kShadesTapsDefault}}));
  EXPECT_LE(plain["pictures"][0]["noise_relative_l1"].get<double>(), 0.02);
  EXPECT_GE(plain["pictures"][0]["samples"].get<int>(), 128);
  const nlohmann::json other = report_of({"--samples", "8", "--taps", "1", "--level-bias", "1", "--pixel-filter",
                                          "tent", "--reference-texels", "interpolated"});
  EXPECT_EQ(other["pictures"][0]["samples"], 8);
  EXPECT_EQ(other["filter"]["level_bias"], 1.0);
  EXPECT_EQ(other["pixel_filter"], "tent");
  EXPECT_EQ(report_of({"--samples", "4", "--anisotropy", "1"})["filter"],
            (nlohmann::json{{"of", "driver"}, {"anisotropy", 1.0}}));
  // If the nearest texel is used, the only remaining error is the error of the baked texels, whatever the number of
  // taps. On this map, that error is 0.
  const auto error = [](const nlohmann::json& report) { return report["pictures"][1]["relative_l1"].get<double>(); };
  EXPECT_LT(error(report_of({"--samples", "1024", "--reference-of", "texels", "--taps", "8"})), 0.03);
}

// The picture of a file of moments equals the picture of the baseline that --compare draws from the source of the file.
TEST_F(ViewTest, DrawsMomentsAsItDrawsItsBaselines) {
  const gl::TestMap map = gl::make_noise_map(32, 1.0f, WrapMode::kPeriodic);
  write_moment_mipmap(path("map.ndf.exr"), gl::make_moments(map.image, StorageEncoding::kHalf), {});
  const auto draw = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "-o",        path("out.png"), "--compare", "reference,toksvig,lean,lean-jacobian",
        "--size",    "64x48",         "--samples", "16",
        "--context", "osmesa",        "--report",  path("r.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::ifstream file(path("r.json"));
    std::map<std::string, double> errors;
    const nlohmann::json report = nlohmann::json::parse(file);
    for (const nlohmann::json& picture : report["pictures"])
      if (picture["name"] != "reference") errors[picture["name"]] = picture["relative_l1"];
    return errors;
  };
  for (const std::string shading : {"toksvig", "lean", "lean-jacobian"}) {
    const std::map<std::string, double> errors = draw({"--moments", shading});
    ASSERT_EQ(errors.size(), 4u);
    EXPECT_NEAR(errors.at("multum"), errors.at(shading), 0.005 * errors.at(shading)) << shading;
  }
  const std::map<std::string, double> usual = draw({});
  EXPECT_NEAR(usual.at("multum"), usual.at("lean-jacobian"), 0.005 * usual.at("lean-jacobian"));
  EXPECT_GT(std::abs(usual.at("toksvig") - usual.at("lean-jacobian")), 0.002);
}

// Order 8 can represent this broad highlight, so the error is small for every BRDF.
TEST_F(ViewTest, DrawsSphericalHarmonics) {
  const gl::TestMap map = gl::make_noise_map(32, 1.0f, WrapMode::kPeriodic);
  write_sh_mipmap(path("map.ndf.exr"), gl::make_harmonics(map.image, 8, StorageEncoding::kHalf), {});
  for (const std::string brdf : {"lambert", "blinn-phong:10", "ggx:0.8"}) {
    const ChildResult result =
        view({"-o", path("out.png"), "--compare", "reference,mip", "--size", "64x48", "--samples", "64", "--context",
              "osmesa", "--report", path("r.json"), "--brdf", brdf});
    ASSERT_EQ(result.exit_code, 0) << result.output;
    std::ifstream file(path("r.json"));
    std::map<std::string, double> errors;
    const nlohmann::json report = nlohmann::json::parse(file);
    for (const nlohmann::json& picture : report["pictures"])
      if (picture["name"] != "reference") errors[picture["name"]] = picture["relative_l1"];
    EXPECT_LT(errors.at("multum"), 0.25) << brdf;  // most of this error comes from the blur in an oblique view
    EXPECT_LT(errors.at("multum"), errors.at("mip")) << brdf;
  }
}

// Returns the two-tilt map. Its lobes either include the width of a BRDF with mean cosine c or have the weights 1/4 and
// 3/4.
gl::TestMap with_roughness(float c) {
  gl::TestMap map = gl::make_two_tilt_map(16, 20.0, StorageEncoding::kFloat, false);
  map.mipmap.header.has_roughness = true;
  map.mipmap.header.mean_cosine = c;
  for (MovmfLevel& level : map.mipmap.levels)
    for (auto& lobes : level.lobes)
      for (glm::vec4& lobe : lobes) lobe = glm::vec4(glm::vec3(lobe) * c, lobe.w);
  return map;
}

gl::TestMap with_weights() {
  gl::TestMap map = gl::make_two_tilt_map(16, 20.0, StorageEncoding::kHalf, false);
  map.mipmap.header.weight_count = 2;
  for (MovmfLevel& level : map.mipmap.levels)
    for (const auto& lobes : level.lobes) {
      std::vector<float>& weights = level.weights.emplace_back();
      for (const glm::vec4& lobe : lobes) weights.insert(weights.end(), {0.25f * lobe.w, 0.75f * lobe.w});
    }
  return map;
}

TEST_F(ViewTest, DrawsLobesThatHaveTheirBrdfIn) {
  const auto error_of = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"-o",        path("out.png"), "--compare", "reference",
                                          "--size",    "64x48",         "--samples", "64",
                                          "--context", "osmesa",        "--report",  path("r.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::ifstream file(path("r.json"));
    return nlohmann::json::parse(file)["pictures"][1]["relative_l1"].get<double>();
  };
  const double without = error_of({"--brdf", "blinn-phong:30"});
  write_movmf_mipmap(path("map.ndf.exr"), with_roughness(31.0f / 32.0f).mipmap, {});
  EXPECT_LT(error_of({}), without + 0.01);
  write_movmf_mipmap(path("map.ndf.exr"), gl::as_gaussians(with_roughness(31.0f / 32.0f).mipmap), {});
  EXPECT_LT(error_of({}), without + 0.06) << "Gaussians of a tilt of 20 degrees";
  write_sh_mipmap(path("map.ndf.exr"),
                  gl::make_harmonics(with_roughness(31.0f / 32.0f).image, 12, StorageEncoding::kFloat, 31.0 / 32.0),
                  {});
  EXPECT_LT(error_of({}), without + 0.03) << "harmonics";
  write_movmf_mipmap(path("map.ndf.exr"), with_roughness(31.0f / 32.0f).mipmap, {});
  fs::remove(path("out.png"));
  expect_refusal({"-o", path("out.png"), "--brdf", "blinn-phong:30"}, 2,
                 {"map.ndf.exr", "baked with roughness", "--brdf"});
  expect_refusal({"-o", path("out.png"), "--roughness", path("r.png")}, 2, {"--roughness", "--source"});
}

// The baselines use the roughness map that an engine would use. A constant roughness gives the BRDF with that width. If
// roughness varies, the perceptual roughness is averaged for each level.
TEST_F(ViewTest, BaselinesHaveTheRoughnessMap) {
  const auto draw = [&](const std::string& baseline, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"-o",        path("out.exr"), "--compare",  "reference," + baseline,
                                          "--size",    "48x32",         "--pictures", path("p"),
                                          "--context", "osmesa",        "--samples",  "4",
                                          "--report",  path("r.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return read_albedo_map(path("p_" + baseline + ".exr"), 48, 32, 1);
  };
  const auto off = [](const ColourMap& a, const ColourMap& b) {
    double difference = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < a.g.size(); ++i) {
      difference += static_cast<double>(std::abs(a.g[i] - b.g[i]));
      sum += static_cast<double>(b.g[i]);
    }
    return difference / sum;
  };
  const gl::TestMap plain = gl::make_two_tilt_map(16, 20.0, StorageEncoding::kFloat, false);
  const auto write = [&](const MovmfMipmap& mipmap) { write_movmf_mipmap(path("map.ndf.exr"), mipmap, {}); };
  // The variance of LEAN's facets is alpha^2 / 2 = 1 / (s + 2) for s = 30, so LEAN is compared with an exponent of 32.
  for (const auto& [baseline, brdf] :
       {std::pair{"mip", "blinn-phong:30"}, std::pair{"toksvig", "blinn-phong:30"}, std::pair{"lean", "blinn-phong:32"},
        std::pair{"lean-jacobian", "blinn-phong:32"}}) {
    SCOPED_TRACE(baseline);
    write(plain.mipmap);
    const ColourMap expected = draw(baseline, {"--brdf", brdf}), sharper = draw(baseline, {"--brdf", "blinn-phong:60"});
    write(with_roughness(31.0f / 32.0f).mipmap);
    const ColourMap drawn = draw(baseline, {});
    EXPECT_LT(off(drawn, expected), 2e-3);
    EXPECT_GT(off(drawn, sharper), 0.02);
    std::ifstream file(path("r.json"));
    const auto report = nlohmann::json::parse(file);
    EXPECT_EQ(report["brdf"], "roughness-map");
    EXPECT_FALSE(report.contains("exponent"));
  }
  // From far away, roughness values that alternate between 0.3 and 0.7 average to 0.5, which gives alpha^2 = 1/16 and c
  // = 31/32.
  gl::TestMap varied = plain;
  varied.mipmap.header.has_roughness = true;
  varied.mipmap.header.mean_cosine = 0.94f;
  for (auto& lobes : varied.mipmap.levels[0].lobes)
    for (std::size_t i = 0; i < lobes.size(); ++i) {
      const auto c = static_cast<float>(mean_cosine_of_roughness(i / 16 % 2 == 0 ? 0.3 : 0.7));
      lobes[i] = glm::vec4(glm::vec3(lobes[i]) * c, lobes[i].w);
    }
  const std::vector<std::string> far = {"--repeat", "4000"};
  for (const char* baseline : {"mip", "toksvig", "lean"}) {
    write(varied.mipmap);
    const ColourMap drawn = draw(baseline, far);
    write(with_roughness(31.0f / 32.0f).mipmap);
    EXPECT_LT(off(drawn, draw(baseline, far)), 5e-3) << baseline;
  }
}

// With weights of 1/4 and 3/4 everywhere, the picture is 1/4 of one BRDF and 3/4 of the other.
TEST_F(ViewTest, BlendsBasisBrdfsByWeights) {
  const auto draw = [&](const std::vector<std::string>& brdfs) {
    std::vector<std::string> arguments = {"-o", path("out.exr"), "--size", "48x32", "--context", "osmesa"};
    for (const std::string& brdf : brdfs) arguments.insert(arguments.end(), {"--brdf", brdf});
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return read_albedo_map(path("out.exr"), 48, 32, 1);
  };
  const auto expect_blend = [&](const std::string& other, const char* what) {
    const ColourMap blended = draw({"blinn-phong:20", other}), broad = draw({"blinn-phong:20"}), sharp = draw({other});
    double difference = 0.0;
    for (std::size_t i = 0; i < blended.g.size(); ++i) {
      const double expected = 0.25 * static_cast<double>(broad.g[i]) + 0.75 * static_cast<double>(sharp.g[i]);
      EXPECT_NEAR(static_cast<double>(blended.g[i]), expected, 2e-3 * expected + 1e-5) << what << ": " << i;
      difference = std::max(difference, std::abs(static_cast<double>(broad.g[i] - sharp.g[i])));
    }
    EXPECT_GT(difference, 0.02) << what << ": the basis is of two BRDFs";
  };
  const gl::TestMap map = with_weights();
  write_movmf_mipmap(path("map.ndf.exr"), gl::as_gaussians(map.mipmap), {});
  expect_blend("cook-torrance:0.1", "Gaussians");
  ShMipmap harmonics = gl::make_harmonics(map.image, 4, StorageEncoding::kHalf);
  harmonics.header.weight_count = 2;
  for (ShLevel& level : harmonics.levels)
    for (int i = 0; i < level.width * level.height; ++i) level.weights.insert(level.weights.end(), {0.25f, 0.75f});
  write_sh_mipmap(path("map.ndf.exr"), harmonics, {});
  expect_blend("ggx:0.5", "harmonics");
  write_movmf_mipmap(path("map.ndf.exr"), map.mipmap, {});
  expect_blend("ggx:0.3", "lobes");
  const ChildResult reference =
      view({"-o", path("out.exr"), "--size", "32x24", "--samples", "16", "--context", "osmesa", "--brdf",
            "blinn-phong:20", "--brdf", "ggx:0.3", "--compare", "reference,mip"});
  EXPECT_EQ(reference.exit_code, 0) << reference.output;
  expect_refusal({"-o", path("out.png"), "--brdf", "lambert", "--brdf", "lambert", "--brdf", "lambert"}, 2,
                 {"map.ndf.exr", "2 weights", "--brdf was given 3 times"});
}

TEST_F(ViewTest, DrawsPlanarGaussiansAndRefusesWhatTheyCannotShow) {
  const auto error_of = [&](const std::string& brdf) {
    const ChildResult result = view({"-o", path("out.png"), "--brdf", brdf, "--compare", "reference", "--size", "64x48",
                                     "--samples", "64", "--report", path("r.json"), "--context", "osmesa"});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    fs::remove(path("out.png"));
    std::ifstream file(path("r.json"));
    return nlohmann::json::parse(file)["pictures"][1]["relative_l1"].get<double>();
  };
  const double lobes = error_of("blinn-phong:100"), grooves = error_of("cook-torrance:0.1");
  const gl::TestMap map = gl::make_two_tilt_map(16, 20.0, StorageEncoding::kSnorm16, false);
  write_movmf_mipmap(path("map.ndf.exr"), gl::as_gaussians(map.mipmap), {});
  EXPECT_LT(error_of("blinn-phong:100"), 1.05 * lobes + 0.02);
  EXPECT_LT(error_of("cook-torrance:0.1"), 1.05 * grooves + 0.02);
  expect_refusal({"-o", path("out.png"), "--brdf", "ggx:0.3"}, 2, {"planar Gaussians", "--brdf ggx"});
  expect_refusal({"-o", path("out.png"), "--formula", "paper"}, 2, {"planar Gaussians", "--formula paper"});
  expect_refusal({"-o", path("out.png"), "--moments", "lean"}, 2, {"--moments needs files of moments"});
}

TEST_F(ViewTest, WritesEachPictureByItself) {
  const ChildResult result = view({"-o", path("out.png"), "--compare", "reference,mip", "--size", "32x24", "--samples",
                                   "4", "--pictures", path("one"), "--context", "osmesa"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* name : {"reference", "multum", "multum_difference", "mip", "mip_difference"})
    EXPECT_TRUE(fs::exists(path(std::string("one_") + name + ".png"))) << name;
  EXPECT_FALSE(fs::exists(path("one_reference_difference.png")));
}

TEST_F(ViewTest, WritesFloatsToExr) {
  const ChildResult result = view({"-o", path("out.exr"), "--size", "32x24", "--context", "osmesa"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(fs::exists(path("out.exr")));
}

// Every BRDF family can be drawn with every kind of light, and the report names the BRDF and the light. Lobes have
// lower errors than averaged normals.
TEST_F(ViewTest, DrawsEveryBrdfUnderEveryLight) {
  std::ofstream(path("fit.json")) << R"({"layers": [{"kernel": [[0], [0], [1], [0], [0], [0]], "bias": [0]},
                                         {"kernel": [[8, 8, 6]], "bias": [-5, -5, -4]}]})";
  write_sky();
  const auto row = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"-o",        path("out.png"), "--compare", "reference,mip", "--size",
                                          "32x24",     "--samples",     "64",        "--report",      path("r.json"),
                                          "--context", "osmesa",        "--camera",  "0,10,12,0,20,0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::ifstream file(path("r.json"));
    const nlohmann::json report = nlohmann::json::parse(file);
    const double error = report["pictures"][1]["relative_l1"];
    EXPECT_LT(error, 0.2) << result.output;
    EXPECT_LT(error, report["pictures"][2]["relative_l1"].get<double>() + 0.01) << result.output;
    return report["brdf"].get<std::string>();
  };
  EXPECT_EQ(row({"--brdf", "lambert"}), "lambert");
  EXPECT_EQ(row({"--brdf", "cook-torrance:0.3,0.5", "--light", "0.2,0.4,1"}), "cook-torrance");
  EXPECT_EQ(row({"--brdf", "ggx:0.6,0.9,0.6,0.2", "--point-light", "0,20,9,80"}), "ggx");
  EXPECT_EQ(row({"--brdf", "charlie:0.3", "--light", "0.2,0.4,1"}), "charlie");
  EXPECT_EQ(row({"--brdf", "charlie:0.8", "--point-light", "0,20,9,80"}), "charlie");
  EXPECT_EQ(row({"--brdf", path("fit.json"), "--light", "0.2,0.4,1"}), "measured");
  EXPECT_EQ(row({"--brdf", "blinn-phong:12", "--environment", path("sky.hdr")}), "blinn-phong");
  EXPECT_EQ(row({"--brdf", "ggx:0.6", "--environment", path("sky.hdr"), "--environment-mode", "sh"}), "ggx");
}

// With an environment, LEAN and Toksvig both use one lobe around the mean normal. Their pictures are equal, and a
// message says so.
TEST_F(ViewTest, LeanIsToksvigInAnEnvironment) {
  write_sky();
  const auto drawn = [&](const std::vector<std::string>& light) {
    std::vector<std::string> arguments = {
        "-o",       path("out.png"), "--compare", "reference,toksvig,lean,lean-jacobian",
        "--size",   "32x24",         "--samples", "4",
        "--report", path("r.json"),  "--context", "osmesa",
        "--camera", "0,10,12,0,20,0"};
    arguments.insert(arguments.end(), light.begin(), light.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::ifstream file(path("r.json"));
    const nlohmann::json pictures = nlohmann::json::parse(file)["pictures"];
    const bool is_same = pictures[2]["relative_l1"] == pictures[3]["relative_l1"] &&
                         pictures[2]["relative_l1"] == pictures[4]["relative_l1"];
    const bool is_said =
        result.output.find("lean and lean-jacobian are drawn in the same way as toksvig") != std::string::npos;
    EXPECT_EQ(is_same, is_said) << pictures << result.output;
    return is_said;
  };
  EXPECT_TRUE(drawn({"--environment", path("sky.hdr")}));
  EXPECT_FALSE(drawn({"--light", "0.2,0.4,1"}));
}

// A file of harmonics is lit by the harmonics of the environment, without an option.
TEST_F(ViewTest, HarmonicsAreShadedInAnEnvironment) {
  write_sky();
  const gl::TestMap map = gl::make_two_tilt_map(16, 30.0, StorageEncoding::kFloat, false);
  write_sh_mipmap(path("map.ndf.exr"), gl::make_harmonics(map.image, 4, StorageEncoding::kFloat), {});
  const auto report = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"-o",       path("out.png"),  "--size",        "32x24",
                                          "--report", path("r.json"),   "--context",     "osmesa",
                                          "--camera", "0,10,12,0,20,0", "--environment", path("sky.hdr")};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::ifstream file(path("r.json"));
    return nlohmann::json::parse(file);
  };
  EXPECT_EQ(report({"--brdf", "blinn-phong:12"})["environment_mode"], "sh");
  EXPECT_EQ(report({"--brdf", "lambert", "--environment-mode", "prefiltered"})["environment_mode"], "prefiltered");
}

TEST_F(ViewTest, AnimatesBetweenTwoScenes) {
  const ChildResult result =
      run({"animate",    path("map.ndf.exr"), "-o",          path("frames"), "--frames", "3",
           "--brdf",     "ggx:0.5",           "--to-brdf",   "ggx:0.1",      "--light",  "0,0.5,1",
           "--to-light", "0.5,0.5,1",         "--to-camera", "0,1,2,0,4,0",  "--size",   "16x12",
           "--report",   path("r.json"),      "--context",   "osmesa"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* name : {"frame_0000.png", "frame_0001.png", "frame_0002.png"})
    EXPECT_TRUE(fs::exists(folder_ / "frames" / name)) << name;
  EXPECT_FALSE(fs::exists(folder_ / "frames" / "frame_0003.png"));
  EXPECT_NE(hash_file((folder_ / "frames" / "frame_0000.png").string()),
            hash_file((folder_ / "frames" / "frame_0002.png").string()));
  std::ifstream file(path("r.json"));
  EXPECT_EQ(nlohmann::json::parse(file)["pictures"].size(), 3u);
  // The first frame equals the picture that is drawn without an animation.
  const ChildResult still = view(
      {"-o", path("still.png"), "--brdf", "ggx:0.5", "--light", "0,0.5,1", "--size", "16x12", "--context", "osmesa"});
  ASSERT_EQ(still.exit_code, 0) << still.output;
  EXPECT_EQ(hash_file(path("still.png")), hash_file((folder_ / "frames" / "frame_0000.png").string()));
  const std::string frames = path("more");
  const auto refuse = [&](std::vector<std::string> arguments, const std::vector<std::string>& parts) {
    arguments.insert(arguments.begin(), {"animate", path("map.ndf.exr"), "-o", frames});
    const ChildResult refused = run(arguments);
    EXPECT_EQ(refused.exit_code, 2) << refused.output;
    testing::expect_says(refused.output, parts);
    EXPECT_FALSE(fs::exists(frames));
  };
  refuse({}, {"animate", "--to-camera", "--to-brdf"});
  refuse({"--to-brdf", "ggx:0.1"}, {"family", "--brdf"});
  refuse({"--to-light", "0,0,1", "--to-light", "0,1,1"}, {"expected the 1 of"});
  refuse({"--to-brdf", "ggx:0.1", "--scene", path("plan.json")}, {"--scene", "file"});
  refuse({"--to-diffuse", "1", "--pictures", path("p")}, {"unknown option '--pictures'"});
  expect_refusal({"-o", path("out.png"), "--to-brdf", "ggx:0.1"}, 2, {"--to-brdf", "'multum-view animate'"});
}

// The last frame equals a single picture with the environment of the last frame.
TEST_F(ViewTest, EnvironmentsChangeFromFrameToFrame) {
  write_sky();
  write_night();
  for (const char* mode : {"prefiltered", "sh"}) {
    const std::vector<std::string> common = {
        "--environment-mode", mode, "--brdf", "blinn-phong:12", "--size", "16x12", "--context", "osmesa"};
    std::vector<std::string> animate = {"animate",
                                        path("map.ndf.exr"),
                                        "-o",
                                        path("frames"),
                                        "--frames",
                                        "3",
                                        "--environment",
                                        path("sky.hdr"),
                                        "--to-environment",
                                        path("night.hdr"),
                                        "--to-environment-turn",
                                        "90",
                                        "--report",
                                        path("r.json")};
    animate.insert(animate.end(), common.begin(), common.end());
    const ChildResult result = run(animate);
    ASSERT_EQ(result.exit_code, 0) << result.output;
    std::vector<std::string> last = {"-o", path("still.png"), "--environment", path("night.hdr"), "--environment-turn",
                                     "90"};
    last.insert(last.end(), common.begin(), common.end());
    const ChildResult still = view(last);
    ASSERT_EQ(still.exit_code, 0) << still.output;
    const auto hash_of = [&](const char* name) { return hash_file((folder_ / "frames" / name).string()); };
    EXPECT_EQ(hash_file(path("still.png")), hash_of("frame_0002.png"));
    EXPECT_NE(hash_of("frame_0001.png"), hash_of("frame_0002.png"));
    EXPECT_NE(hash_of("frame_0001.png"), hash_of("frame_0000.png"));
    // A single time can be shorter than the clock's resolution.
    std::ifstream file(path("r.json"));
    const nlohmann::json report = nlohmann::json::parse(file);
    double set = 0.0;
    for (const nlohmann::json& frame : report["pictures"])
      set += frame[0]["environment_processor_ms"]["set"].get<double>();
    EXPECT_GT(set, 0.0);
  }
  expect_refusal({"-o", path("out.png"), "--environment-turn", "10"}, 2,
                 {"--environment-turn", "require --environment"});
}

// Draws a file that begins at level 1 or 2, together with the normal map, which provides the finer levels.
class FirstLevelViewTest : public ViewTest {
 protected:
  static constexpr int kSize = 32;
  void SetUp() override {
    ViewTest::SetUp();
    map_ = gl::make_noise_map(kSize, 0.4f, WrapMode::kPeriodic);
    std::vector<std::uint16_t> codes;
    for (const glm::vec3& n : map_.image.normals)
      for (int c = 0; c < 3; ++c)
        codes.push_back(static_cast<std::uint16_t>(std::lround((n[c] * 0.5f + 0.5f) * 65535.0f)));
    write_png16(path("n.png"), kSize, kSize, codes, "Linear");
    nlohmann::json settings;
    NormalMapSettings reading;
    reading.bump_format = BumpFormat::kNormal;
    reading.green = GreenAxis::kUp;
    add_reading_settings(reading, settings);
    map_.mipmap.header.provenance.settings = settings.dump();
    map_.mipmap.header.provenance.source_name = "n.png";
    map_.mipmap.header.provenance.source_hash = hash_file(path("n.png"));
  }
  void write_from(int first_level) {
    drop_finer_levels(map_.mipmap, first_level);
    write_movmf_mipmap(path("map.ndf.exr"), map_.mipmap, {});
  }
  // Returns the error of the picture, compared with the reference, which is drawn from the same source.
  double error(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"-o",        path("out.png"),  "--source", path("n.png"),  "--compare",
                                          "reference", "--size",         "64x48",    "--samples",    "16",
                                          "--brdf",    "blinn-phong:20", "--report", path("r.json"), "--context",
                                          "osmesa"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_EQ(result.output.find("warning"), std::string::npos) << result.output;
    std::ifstream file(path("r.json"));
    return nlohmann::json::parse(file)["pictures"][1]["relative_l1"].get<double>();
  }
  gl::TestMap map_;
};

TEST_F(FirstLevelViewTest, FromAfarPicturesAreThoseOfAFileThatHoldsEveryLevel) {
  const std::vector<std::string> far = {"--camera", "0,30,60,0,30,0,40", "--repeat", "10"};  // 3.6 texels per pixel
  write_from(0);
  const double whole = error(far);
  EXPECT_GT(whole, 0.01) << "averages must have errors on this map, or the test compares nothing";
  for (const int first_level : {1, 2}) {
    write_from(first_level);
    EXPECT_NEAR(error(far), whole, 0.1 * whole) << first_level;
  }
  // A picture without --compare also needs the source.
  const ChildResult alone =
      view({"-o", path("alone.png"), "--source", path("n.png"), "--size", "16x12", "--context", "osmesa"});
  EXPECT_EQ(alone.exit_code, 0) << alone.output;
  EXPECT_EQ(alone.output.find("is not read"), std::string::npos) << alone.output;
}

// Each pixel covers half a texel.
TEST_F(FirstLevelViewTest, NearTheNormalMapIsTheSurfaceBetweenTexels) {
  const std::vector<std::string> near = {"--camera", "0,30,60,0,30,0,40",  "--repeat",
                                         "1.29",     "--reference-texels", "interpolated"};
  std::vector<std::string> facets = near;
  facets.insert(facets.end(), {"--surface", "texels"});
  write_from(0);
  const double stored = error(facets);
  EXPECT_LT(error(near), 0.75 * stored);
  write_from(1);
  EXPECT_LT(error(near), 0.75 * stored);
}

TEST_F(FirstLevelViewTest, TheNormalMapIsAskedForByName) {
  write_from(1);
  const std::string out = path("out.png");
  expect_refusal({"-o", out}, 2, {"map.ndf.exr: ", "levels 1 to 5 of 0 to 5", "32 x 32", "no --source"});
  expect_refusal({"-o", out}, 2, {"(n.png, SHA-256 " + map_.mipmap.header.provenance.source_hash + ")"});
  expect_refusal({"-o", out, "--source", path("none.png")}, 3, {"none.png"});
  std::vector<std::uint16_t> flat;
  for (int i = 0; i < 16 * 16; ++i) flat.insert(flat.end(), {32768, 32768, 65535});
  write_png16(path("small.png"), 16, 16, flat, "Linear");
  expect_refusal({"-o", out, "--source", path("small.png")}, 3, {"small.png: ", "16 x 16"});
  expect_refusal({"-o", out, "--source", path("small.png")}, 3, {"baked from", "32 x 32"});
  flat.clear();
  for (int i = 0; i < kSize * kSize; ++i) flat.insert(flat.end(), {32768, 32768, 65535});
  write_png16(path("other.png"), kSize, kSize, flat, "Linear");
  const ChildResult other = view({"-o", out, "--source", path("other.png"), "--size", "8x8", "--context", "osmesa"});
  EXPECT_EQ(other.exit_code, 0) << other.output;
  testing::expect_says(other.output, {"other.png", "not the file"});
  testing::expect_says(other.output, {"finest levels", "reference", "baselines"});
}

TEST_F(FirstLevelViewTest, ColoursWithoutTheirMapAreWarnedOf) {
  for (MovmfLevel& level : map_.mipmap.levels)
    level.colours = {std::vector<glm::vec3>(level.lobes[0].size(), glm::vec3(0.2f, 0.5f, 0.8f))};
  write_from(2);
  std::vector<std::string> arguments = {"-o",     path("out.png"), "--source",  path("n.png"),
                                        "--size", "8x8",           "--context", "osmesa"};
  const std::string warning = "without --albedo";
  testing::expect_says(view(arguments).output, {"level 2", warning});
  write_png16(path("a.png"), kSize, kSize, std::vector<std::uint16_t>(3 * kSize * kSize, 30000), "sRGB");
  arguments.insert(arguments.end(), {"--albedo", path("a.png")});
  const ChildResult result = view(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(result.output.find(warning), std::string::npos) << result.output;
}

TEST_F(ViewTest, MeshesStandUprightUnderAnyCamera) {
  write_text_file(path("quad.obj"),
                  "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n"
                  "f 1/1/1 2/2/1 3/3/1\n");
  // Uses PNG, because OpenImageIO writes the date into an EXR.
  const auto picture = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"-o",     path("out.png"), "--mesh",    path("quad.obj"),
                                          "--size", "32x24",         "--context", "osmesa"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::ifstream file(path("out.png"), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::vector<std::string> oblique = {"--camera", "0,3,3,0,0,0"};
  EXPECT_TRUE(picture(oblique) == picture({"--camera", "0,3,3,0,0,0", "--up", "0,2,0"}));
  EXPECT_TRUE(picture(oblique) != picture({"--camera", "0,3,3,0,0,0", "--up", "0,0,1"}));
  EXPECT_TRUE(picture({}) == picture({"--up", "0,1,0"}));
  EXPECT_TRUE(picture({}) != picture({"--up", "0,0,1"}));
}

TEST_F(ViewTest, AMeshIsDrawnFromNearAndFar) {
  write_text_file(path("quad.obj"),
                  "v 9 -1 0\nv 11 -1 0\nv 11 1 0\nv 9 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                  "f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\n");
  const std::vector<std::string> quad = {"--mesh", path("quad.obj"), "--size",    "64x64",
                                         "-o",     path("out.exr"),  "--context", "osmesa"};
  const auto draw = [&](std::vector<std::string> more) {
    more.insert(more.end(), quad.begin(), quad.end());
    const ChildResult result = view(more);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return result.output;
  };
  const auto lit = [&](const std::string& name) {
    const ColourMap picture = read_albedo_map(path(name), 64, 64, 1);
    return std::count_if(picture.r.begin(), picture.r.end(), [](float value) { return value > 0.0f; });
  };
  const std::string said = draw({"--distance", "1,2,8.5", "--report", path("r.json"), "--pictures", path("each")});
  testing::expect_says(said, {"x 9 to 11, y -1 to 1, z 0 to 0", "--camera ", "out_1.exr", "out_8.5.exr: 8.5 times"});
  EXPECT_FALSE(fs::exists(path("out.exr")));
  for (const char* name : {"each_1_multum.exr", "each_2_multum.exr", "each_8.5_multum.exr"})
    EXPECT_TRUE(fs::exists(path(name))) << name;
  // The number of lit pixels falls with about the square of the distance.
  const auto near = static_cast<double>(lit("out_1.exr"));
  EXPECT_GT(near, 0.45 * 64 * 64) << "it fills the picture";
  EXPECT_NEAR(static_cast<double>(lit("out_2.exr")) / near, 1.0 / 4.0, 0.05);
  EXPECT_NEAR(static_cast<double>(lit("out_8.5.exr")) / near, 1.0 / 72.25, 0.01);
  std::ifstream file(path("r.json"));
  const auto report = nlohmann::json::parse(file);
  ASSERT_EQ(report["pictures"].size(), 3u);
  EXPECT_EQ(report["pictures"][2]["distance"], 8.5);
  // The printed camera draws the same picture again.
  const std::size_t at = said.find("--camera ") + 9;
  draw({"--camera", said.substr(at, said.find(':', at) - at)});
  EXPECT_NEAR(static_cast<double>(lit("out.exr")), near, 8.0);
  for (const std::string list : {"1,1", "0", "1,x", "-1", "20000"})
    expect_refusal({"--distance", list, "--mesh", path("quad.obj"), "-o", path("out.png")}, 2, {"--distance", list});
  expect_refusal({"--distance", "1,2", "-o", path("out.png")}, 2, {"--distance", "--mesh"});
  write_text_file(path("out_2.exr"), "as it was");
  expect_refusal(
      {"--mesh", path("quad.obj"), "--distance", "1,2", "-o", path("out.png"), "--report", path("out_2.png")}, 2,
      {"out_2.png", "twice"});
}

TEST_F(ViewTest, TheEnvironmentIsSeenBehindWhatItLights) {
  write_text_file(path("quad.obj"),
                  "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1/1 2/2/1 3/3/1\n");
  write_sky();
  const auto corner = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"-o",     path("out.exr"), "--mesh",        path("quad.obj"), "--diffuse",
                                          "0",      "--size",        "32x32",         "--context",      "osmesa",
                                          "--brdf", "lambert",       "--environment", path("sky.hdr")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    const ColourMap picture = read_albedo_map(path("out.exr"), 32, 32, 1);
    EXPECT_EQ(picture.r[16 * 32 + 16], 0.0f) << "a black object stands before it";
    return picture.r[0];
  };
  EXPECT_GT(corner({}), 0.1f);
  EXPECT_EQ(corner({"--no-background"}), 0.0f);
}

// The thumbnails that were made before a failure are kept, and the service shows them.
TEST_F(ViewTest, ThumbnailsAreMadeUntilSomethingFails) {
  const auto make = [&](const std::string& source) {
    fs::remove_all(path("small"));
    fs::create_directory(path("small"));
    // This is the service's own command line.
    std::vector<std::string> arguments = {"thumbnails", "--context=osmesa", "--output=" + path("small")};
    if (!source.empty()) arguments.push_back("--source=" + path(source));
    arguments.insert(arguments.end(), {"--", path("map.ndf.exr")});
    return run(arguments);
  };
  const auto names = [&] {
    std::set<std::string> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(path("small")))
      found.insert(entry.path().filename().string());
    return found;
  };
  std::vector<std::uint16_t> texels;
  for (int i = 0; i < 16 * 16; ++i) texels.insert(texels.end(), {32768, 32768, 65535});
  write_png16(path("flat.png"), 16, 16, texels, "Linear");
  EXPECT_EQ(make("").exit_code, 0);
  EXPECT_EQ(names(), std::set<std::string>({"render.png"}));
  // The file does not contain a hash, so that any source is accepted.
  const ChildResult all = make("flat.png");
  EXPECT_EQ(all.exit_code, 0) << all.output;
  EXPECT_EQ(names(), std::set<std::string>({"render.png", "input.png", "error.png"}));

  gl::TestMap map = gl::make_two_tilt_map(16, 20.0, StorageEncoding::kSnorm16, false);
  map.mipmap.header.provenance.source_hash = std::string(64, '0');
  write_movmf_mipmap(path("map.ndf.exr"), map.mipmap, {});
  const ChildResult changed = make("flat.png");
  EXPECT_EQ(changed.exit_code, 3);
  testing::expect_says(changed.output, {"changed", "since it was baked"});
  EXPECT_EQ(names(), std::set<std::string>({"render.png"}));
}

}  // namespace
}  // namespace multum
