// SPDX-License-Identifier: Apache-2.0
// Tests multum mip, reflectance, lod and materials: their files as other programs read them, the changes that they
// notice, and their refusals.
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/formats/asset/pyramid/pyramid_file.h"
#include "host/formats/image/colour_map.h"
#include "host/foundation/base/base64.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class PyramidCommandTest : public CliTest {
 protected:
  void expect_refused(const std::vector<std::string>& arguments, int code,
                      const std::vector<std::string>& parts) const {
    expect_refusal(multum(arguments), code, parts);
    EXPECT_EQ(folder_.names().count("out.exr"), 0u);
  }
  /// Writes a PNG of 11 x 6 pixels, whose codes increase steadily.
  TestImage ramp() const {
    TestImage image{.width = 11, .height = 6, .channels = 3};
    for (int i = 0; i < 11 * 6 * 3; ++i) image.values.push_back(static_cast<float>((i * 37) % 256) / 255.0f);
    return image;
  }
  void write(const std::string& name, const TestImage& image) const { write_test_image(path(name), image); }
};

// OpenImageIO reads the linear values of every level, and the wrap modes. The last texel is the mean in linear light.
TEST_F(PyramidCommandTest, OpenImageIoReadsTheLevels) {
  write("a.png", ramp());
  const ProgramResult result =
      multum({"mip", path("a.png"), "-o", path("out.exr"), "--swrap", "clamp", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto file = OIIO::ImageInput::open(path("out.exr"));
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(file->spec().get_string_attribute("wrapmodes"), "clamp,periodic");
  EXPECT_EQ(file->spec().format, OIIO::TypeDesc::HALF);
  EXPECT_GT(file->spec().tile_width, 0);
  std::vector<std::pair<int, int>> sizes;
  for (int l = 0; file->seek_subimage(0, l); ++l) sizes.emplace_back(file->spec().width, file->spec().height);
  EXPECT_EQ(sizes, (std::vector<std::pair<int, int>>{{11, 6}, {5, 3}, {2, 1}, {1, 1}}));
  float last[3] = {};
  ASSERT_TRUE(file->read_image(0, 3, 0, 3, OIIO::TypeDesc::FLOAT, last));
  double mean[3] = {};
  const TestImage source = ramp();
  for (std::size_t i = 0; i < source.values.size(); ++i)
    mean[i % 3] += linear_from_srgb(static_cast<double>(source.values[i])) / 66.0;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(static_cast<double>(last[c]), mean[c], 3e-4) << c;

  const auto report = nlohmann::json::parse(read_bytes(path("r.json")));
  EXPECT_EQ(report["levels"], 4);
  EXPECT_GT(report["launches"]["mip_levels"], 0);
  EXPECT_EQ(report["content_hash"], read_pyramid_header(path("out.exr")).map.provenance.content_hash);
  EXPECT_NE(multum({"info", path("out.exr")}).out.find("pyramid of colours"), std::string::npos);
  EXPECT_EQ(multum({"verify", path("out.exr")}).exit_code, 0);
}

TEST_F(PyramidCommandTest, SaysWhatItTakesNumbersFor) {
  write("a.png", ramp());
  const auto first = [&](const std::string& colours) {
    EXPECT_EQ(multum({"mip", path("a.png"), "-o", path("b.exr"), "--colours", colours, "-d", "float"}).exit_code, 0);
    return read_pyramid(path("b.exr")).levels[0].values[1];
  };
  const float code = std::round(ramp().values[1] * 255.0f) / 255.0f;
  EXPECT_NEAR(first("auto"), linear_from_srgb(static_cast<double>(code)), 1e-6);
  EXPECT_NEAR(first("linear"), code, 1e-6f);
  EXPECT_NEAR(first("data"), code, 1e-6f);
}

TEST_F(PyramidCommandTest, IsRecognisedAndTheSameForAnyMemory) {
  write("a.png", ramp());
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"mip", path("a.png"), "-o", path("b.exr")});
    return multum(more);
  };
  ASSERT_EQ(run({}).exit_code, 0);
  const std::string bytes = read_bytes(path("b.exr"));
  EXPECT_NE(run({}).out.find("unchanged"), std::string::npos);
  EXPECT_EQ(run({"--force", "--memory", "64K", "--threads", "1"}).out.find("unchanged"), std::string::npos);
  EXPECT_EQ(read_bytes(path("b.exr")), bytes);
  EXPECT_EQ(run({"--wrap", "mirror"}).out.find("unchanged"), std::string::npos);
  EXPECT_EQ(read_pyramid_header(path("b.exr")).map.wrap_t, WrapMode::kMirror);
}

TEST_F(PyramidCommandTest, RefusesWhatCannotBe) {
  write("a.png", ramp());
  TestImage pair{.width = 2, .height = 1, .channels = 2, .values = {0, 0, 1, 1}, .type = OIIO::TypeDesc::FLOAT};
  write("pair.tif", pair);
  TestImage nan{
      .width = 2, .height = 1, .channels = 3, .values = {0, 0, 0, 1, 1, std::nanf("")}, .type = OIIO::TypeDesc::FLOAT};
  write("nan.exr", nan);
  TestImage grey{.width = 2, .height = 2, .channels = 1, .values = {0, 0, 0, 1}};
  write("grey.png", grey);
  const std::string out = path("out.exr");
  expect_refused({"mip", path("none.png"), "-o", out}, kInput, {"none.png"});
  expect_refused({"mip", path("pair.tif"), "-o", out}, kInput, {"pair.tif", "2 colour channels"});
  expect_refused({"mip", path("a.png"), "-o", path("a.png")}, kUsage, {"a.png", "twice"});
  expect_refused({"mip", path("a.png"), "-o", path("out.png")}, kUsage, {"out.png", ".exr"});
  expect_refused({"mip", path("a.png"), "-o", "/proc/no/out.exr"}, kEnvironment, {"no"});
  expect_refused({"mip", path("a.png"), "-o", out, "--memory", "1K"}, kUsage, {"--memory"});
  expect_refused({"lod", path("nan.exr"), "-o", out}, kInput, {"nan.exr", "1 texels", "not finite"});
  expect_refused({"lod", path("grey.png"), "-o", out, "--of", "positions"}, kInput, {"grey.png", "3", "positions"});
  expect_refused({"lod", path("grey.png"), "-o", out, "--scale", "0"}, kUsage, {"--scale", "0"});
  expect_refused({"reflectance", "-o", out}, kUsage, {"--light", "--environment"});
  expect_refused({"reflectance", "-o", out, "--light", "0,0,0"}, kUsage, {"--light"});
  expect_refused({"reflectance", "-o", out, "--light", "up"}, kUsage, {"--light", "'up'"});
  expect_refused({"reflectance", "-o", out, "--light", "0,0,1", "--brdf", "ggx:0.3"}, kUsage,
                 {"ggx:0.3", "blinn-phong:S"});
  expect_refused({"reflectance", "-o", out, "--light", "0,0,1", "--brdf", "blinn-phong:0"}, kUsage,
                 {"--brdf", "1 to 100000"});
  expect_refused({"reflectance", "-o", out, "--light", "0,0,1", "--size", "2"}, kUsage, {"--size", "2", "4 to 8192"});
  expect_refused({"reflectance", "-o", out, "--environment", path("none.exr")}, kInput, {"none.exr"});
}

// A clear message says that a pyramid is not a baked map. Damage in a pyramid is found.
TEST_F(PyramidCommandTest, DamageShows) {
  write("a.png", ramp());
  ASSERT_EQ(multum({"mip", path("a.png"), "-o", path("b.exr"), "--compression", "none"}).exit_code, 0);
  std::string bytes = read_bytes(path("b.exr"));
  for (std::size_t i = 1; i < 60; ++i) bytes[bytes.size() - i] ^= 0x11;  // the pixels of the coarsest levels are here
  write_bytes(path("c.exr"), bytes);
  const ProgramResult result = multum({"verify", path("c.exr")});
  EXPECT_NE(result.exit_code, 0) << result.out;
  write_bytes(path("d.exr"), read_bytes(path("b.exr")).substr(0, 700));
  EXPECT_EQ(multum({"verify", path("d.exr")}).exit_code, kInput);
}

TEST_F(PyramidCommandTest, HeightsKeepTheirSignAndPositionsTheirThree) {
  TestImage grid{.width = 3, .height = 2, .channels = 3, .values = {}, .type = OIIO::TypeDesc::FLOAT};
  for (int i = 0; i < 18; ++i) grid.values.push_back(static_cast<float>(i) - 9.0f);
  write("grid.exr", grid);
  ASSERT_EQ(multum({"lod", path("grid.exr"), "-o", path("p.exr"), "--of", "positions"}).exit_code, 0);
  const Pyramid positions = read_pyramid(path("p.exr"), PyramidKind::kPosition);
  EXPECT_EQ(positions.levels[0].values, grid.values);
  EXPECT_EQ(positions.header.map.wrap_s, WrapMode::kClamp);
  EXPECT_EQ(positions.levels[1].values, (std::vector<float>{-1.5f, -0.5f, 0.5f}));
  ASSERT_EQ(multum({"lod", path("grid.exr"), "-o", path("h.exr"), "--scale", "-2"}).exit_code, 0);
  EXPECT_EQ(read_pyramid(path("h.exr")).levels[1].values, std::vector<float>{3.0f});
  EXPECT_THROW(read_pyramid(path("h.exr"), PyramidKind::kPosition), Error);
}

TEST_F(PyramidCommandTest, ReflectanceRemembersItsLights) {
  const std::vector<std::string> command = {"reflectance",    "-o",       path("r.exr"), "--light",
                                            "0,0,2,3.5",      "--size",   "16",          "--brdf",
                                            "blinn-phong:20", "--viewer", "0,0.6,0.8"};
  ASSERT_EQ(multum(command).exit_code, 0);
  const auto settings = nlohmann::json::parse(read_pyramid_header(path("r.exr")).map.provenance.settings);
  EXPECT_EQ(settings["lights"][0]["irradiance"][2], 3.5);
  EXPECT_EQ(settings["exponent"], 20.0);
  EXPECT_NEAR(settings["frame"]["viewer"][1].get<double>(), 0.6, 1e-12);
  EXPECT_NE(multum(command).out.find("unchanged"), std::string::npos);
}

// Returns a model of two materials with normal maps. One map is embedded. The other map is in a separate file and has a
// scale.
std::string model(const std::string& more) {
  return R"({"asset":{"version":"2.0"},"materials":[)"
         R"({"name":"steel","normalTexture":{"index":0,"scale":0.5},"pbrMetallicRoughness":{"metallicFactor":0.25}},)"
         R"({"normalTexture":{"index":1},"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}},)"
         R"({"name":"plain","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,1,1],"roughnessFactor":0.1}}],)"
         R"("textures":[{"source":0,"sampler":0},{"source":1}],"samplers":[{"wrapS":33071,"wrapT":33648}],)"
         R"("images":[{"uri":"n%20map.png"},{"name":"inside","uri":"data:image/png;base64,)" +
         more + R"("}]})";
}

TEST_F(PyramidCommandTest, MaterialsOfAModelAreBakedByTheirManifest) {
  write("n map.png", normal_image(16, 16));
  write_bytes(path("m.gltf"), model(encode_base64(read_bytes(path("n map.png")))));
  const ProgramResult listed = multum({"materials", path("m.gltf"), "-o", path("maps")});
  ASSERT_EQ(listed.exit_code, 0) << listed.err;
  for (const char* part : {"steel\n", "wrap clamp,mirror, scale 0.5", "material 1", "inside.png (inside the file)",
                           "base colour   0.5,0.25,1 times 1", "roughness     0.1", "metallic      0.25", ": 2 maps"})
    EXPECT_NE(listed.out.find(part), std::string::npos) << part << " is not in\n" << listed.out;
  EXPECT_EQ(read_bytes(path("maps/inside.png")), read_bytes(path("n map.png")));
  const ProgramResult baked = multum({"bake", "--manifest", path("maps/maps.toml")});
  ASSERT_EQ(baked.exit_code, 0) << baked.err;
  const BakedHeader steel = read_baked_header(path("maps/0_steel.ndf.exr"));
  EXPECT_EQ(steel.wrap_s, WrapMode::kClamp);
  EXPECT_EQ(steel.wrap_t, WrapMode::kMirror);
  EXPECT_EQ(nlohmann::json::parse(steel.provenance.settings)["normal_scale"], 0.5);
  EXPECT_FALSE(nlohmann::json::parse(read_baked_header(path("maps/1_material_1.ndf.exr")).provenance.settings)
                   .contains("normal_scale"));
  EXPECT_TRUE(read_baked_header(path("maps/1_material_1.ndf.exr")).has_colours);
  const ProgramResult again = multum({"materials", path("m.gltf"), "-o", path("maps")});
  expect_refusal(again, kUsage, {"maps.toml", "already exists"});
}

TEST_F(PyramidCommandTest, MaterialsRefuseWhatTheyCannotCarry) {
  const auto refused = [&](const std::string& json, const std::vector<std::string>& parts) {
    write_bytes(path("bad.gltf"), json);
    expect_refusal(multum({"materials", path("bad.gltf"), "-o", path("maps")}), kInput, parts);
    EXPECT_EQ(folder_.names().count("maps"), 0u);
  };
  refused("{", {"bad.gltf", "JSON"});
  refused(R"({"asset":{}})", {"bad.gltf", "no materials"});
  refused(R"({"materials":[{"name":"a"}]})", {"bad.gltf", "no material", "normal map"});
  refused(R"({"materials":[{"normalTexture":{"index":3}}]})",
          {"bad.gltf", "normalTexture/index is 3", "length of textures"});
  refused(R"({"materials":[{"pbrMetallicRoughness":{"metallicFactor":7}}]})", {"bad.gltf", "factor of 7", "0 to 1"});
  refused(R"({"images":[{"uri":"data:image/png;base64,AAAA"}],"materials":[]})", {"bad.gltf", "PNG", "JPEG", "WebP"});
  refused(R"({"images":[{"uri":"http://x/y.png"}],"materials":[]})",
          {"bad.gltf", "http://x/y.png", "file in its folder"});
  for (const std::string uri : {"../map_normal.png", "%2e%2e/secret.png", "a/../../secret.png", "/etc/passwd", ".."})
    refused(R"({"images":[{"uri":")" + uri + R"("}],"materials":[]})", {"bad.gltf", "folder"});
  refused(R"({"images":[{"bufferView":1}],"bufferViews":[],"materials":[]})", {"bad.gltf", "images/0/bufferView is 1"});
  refused(R"({"images":[{"uri":"a.png"}],"textures":[{"source":0}],"materials":[{"normalTexture":{"index":0,)"
          R"("extensions":{"KHR_texture_transform":{"scale":[2,2]}}}}]})",
          {"bad.gltf", "KHR_texture_transform"});
  refused(R"({"materials":[{"normalTexture":"none"}]})", {"bad.gltf", "damaged"});
}

}  // namespace
}  // namespace multum::testing
