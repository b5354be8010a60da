// SPDX-License-Identifier: Apache-2.0
// Tests multum export: the images as OpenImageIO reads them, the report, the refusals, and the files that remain after
// an interruption. Also tests that the bytes do not depend on the memory limit.
#include <OpenImageIO/imageio.h>

#include <signal.h>
#include <zstd.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "host/delivery/export/texel_format.h"
#include "host/foundation/base/base64.h"
#include "tests/cli/exports/export_test.h"

namespace multum::testing {
namespace {

class ExportCommandTest : public ExportTest {};

TEST_F(ExportCommandTest, OpenImageIoReadsTheLevels) {
  write("map.png", normal_image(35, 22));
  const ProgramResult result =
      run({"--anisotropy", "--base-roughness", "0.2", "--report", path("r.json"), "--cells", "3", "-v"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::pair<int, int> sizes[] = {{35, 22}, {17, 11}, {8, 5}, {4, 2}, {2, 1}, {1, 1}};
  for (std::size_t l = 0; l < std::size(sizes); ++l)
    for (const char* texture : {"normal_0", "orm_0", "anisotropy_0"}) {
      const Picture picture = level(texture + std::to_string(l) + ".png");
      EXPECT_EQ(std::make_pair(picture.width, picture.height), sizes[l]);
      EXPECT_EQ(picture.channels, 3);
      EXPECT_FALSE(picture.is_half);
    }
  // The finest level is the map itself, with the base roughness because no roughness map was given.
  const Picture source = read_picture(path("map.png")), finest = level("normal_00.png"), orm = level("orm_00.png");
  for (int y = 0; y < 22; ++y)
    for (int x = 0; x < 35; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(finest.at(x, y, c), source.at(x, y, c), 2.5f / 255.0f) << x << ", " << y;
  EXPECT_NEAR(orm.at(3, 4, 1), 0.2f, 0.5f / 255.0f);
  EXPECT_EQ(orm.at(3, 4, 0), 1.0f);
  EXPECT_EQ(orm.at(3, 4, 2), 0.0f) << "without a metalness map the surface is not metal";
  EXPECT_EQ(level("anisotropy_00.png").at(3, 4, 2), 0.0f);
  // The coarsest level is rougher than the base roughness, and its anisotropy axis is a unit vector.
  EXPECT_GT(level("orm_05.png").at(0, 0, 1), 0.3f);
  const Picture axis = level("anisotropy_05.png");
  EXPECT_NEAR(std::hypot(2.0f * axis.at(0, 0, 0) - 1.0f, 2.0f * axis.at(0, 0, 1) - 1.0f), 1.0f, 0.02f);

  const auto report = nlohmann::json::parse(read_bytes(path("r.json")));
  EXPECT_EQ(report["levels"], 6);
  EXPECT_EQ(report["files"].size(), 18u);
  for (const std::string name : report["files"]) EXPECT_TRUE(std::filesystem::exists(name)) << name;
  for (const char* kernel : {"one_lobe_finest", "one_lobe_samples", "one_lobe_fit"})
    EXPECT_GT(report["launches"][kernel], 0) << kernel;
  // The export does not measure levels that the map does not have.
  ASSERT_EQ(report["accuracy"]["levels"].size(), 2u);
  const auto& rules = report["accuracy"]["levels"][0]["rules"];
  EXPECT_EQ(report["accuracy"]["cells"].size(), 5u);  // level 4 has two texels
  EXPECT_LT(rules["export"]["error"], rules["averaged"]["error"]);
  EXPECT_LT(rules["export"]["error"], rules["unreal"]["error"]);
  EXPECT_NEAR(rules["export"]["energy"].get<double>(), 1.0, 0.1);
  EXPECT_NE(result.out.find("Unreal"), std::string::npos);
}

TEST_F(ExportCommandTest, CarriesMapsOfTheMaterial) {
  write("map.png", normal_image(32, 16));
  TestImage orm{.width = 32, .height = 16, .channels = 3};
  for (int i = 0; i < 32 * 16; ++i)
    for (const double value : {0.25, i % 2 == 0 ? 0.2 : 0.8, i % 4 < 2 ? 0.0 : 1.0})
      orm.values.push_back(static_cast<float>(value));
  write("orm.png", orm);
  ASSERT_EQ(run({"--roughness", path("orm.png"), "--occlusion", path("orm.png"), "--metalness", path("orm.png"),
                 "--format", "exr", "--no-measure"})
                .exit_code,
            0);
  const Picture finest = level("orm_00.exr"), second = level("orm_01.exr"), last = level("orm_05.exr");
  EXPECT_TRUE(finest.is_half);
  EXPECT_NEAR(finest.at(0, 0, 1), 0.2f, 2e-3f);
  EXPECT_NEAR(finest.at(1, 0, 1), 0.8f, 2e-3f);
  EXPECT_NEAR(second.at(0, 0, 0), 64.0f / 255.0f, 1e-3f);  // 0.25 in 8 bits
  EXPECT_NEAR(second.at(0, 0, 2), 0.0f, 1e-3f);
  EXPECT_NEAR(second.at(1, 0, 2), 1.0f, 1e-3f);
  EXPECT_NEAR(last.at(0, 0, 2), 0.5f, 1e-3f);
  // Half of all facets have roughness 0.2, and half have 0.8.
  EXPECT_GT(second.at(0, 0, 1), 0.4f);
  EXPECT_LT(second.at(0, 0, 1), 0.8f);
  // Gloss is 1 - roughness. The option may name a channel.
  ASSERT_EQ(run({"--gloss", path("orm.png") + ":R", "--format", "exr", "--no-measure"}).exit_code, 0);
  EXPECT_NEAR(level("orm_00.exr").at(0, 0, 1), 1.0f - 64.0f / 255.0f, 1e-3f);
  EXPECT_EQ(level("orm_00.exr").at(0, 0, 0), 1.0f);
}

// Describes a way to store a material and the formats of its textures.
struct Stored {
  std::vector<std::string> options;
  bool has_zstd;
  std::vector<std::pair<std::string, TexelFormat>> textures;
};

std::vector<Stored> stored_kinds() {
  using enum TexelFormat;
  return {{{"--anisotropy"}, false, {{"normal", kRgba8}, {"orm", kRgba8}, {"anisotropy", kRgba8}}},
          {{"--texels", "rgba16f", "--zstd", "3"}, true, {{"normal", kRgba16f}, {"orm", kRgba16f}}},
          {{"--texels", "rg8", "--packing", "separate"}, false, {{"normal", kRg8}, {"roughness", kR8}}},
          {{"--texels", "rg8", "--zstd", "19"}, true, {{"normal", kRg8}, {"orm", kRgba8}}},
          {{"--texels", "bc", "--anisotropy"}, false, {{"normal", kBc5}, {"orm", kBc7}, {"anisotropy", kBc7}}},
          {{"--texels", "bc", "--packing", "separate", "--zstd", "10"}, true, {{"normal", kBc5}, {"roughness", kBc4}}}};
}

// The independent reader ktx-parse finds the expected format in each KTX2 file, and the same texels as in the images.
TEST_F(ExportCommandTest, KtxParseReadsTheLevels) {
  const std::string script = MULTUM_SOURCE_DIR "/tests/cli/exports/ktx2_reading.mjs";
  if (!program_works("node", "--version")) GTEST_SKIP() << "no node (Debian package nodejs)";
  if (run_program({"node", script}).exit_code != 0) GTEST_SKIP() << "no ktx-parse: tools/install_dependencies test";
  write("map.png", normal_image(35, 22));
  for (const Stored& kind : stored_kinds()) {
    const bool is_half = kind.textures[0].second == TexelFormat::kRgba16f;
    std::vector<std::string> options = kind.options;
    options.insert(options.end(), {"--no-measure", "--format", "ktx2"});
    const ProgramResult exported = run(options);
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    expect_says(exported.err, {"35 x 22", "powers of two"});
    EXPECT_EQ(exported.err.find("multiples of 4") != std::string::npos, kind.textures[0].second == TexelFormat::kBc5);
    std::vector<std::string> images = {"--no-measure", "--format", is_half ? "exr" : "png"};
    if (kind.textures.size() == 3) images.insert(images.end(), "--anisotropy");
    ASSERT_EQ(run(images).exit_code, 0);
    std::vector<std::string> command = {"node", script};
    for (const auto& [name, format] : kind.textures) command.push_back(path("out/" + name + ".ktx2"));
    const ProgramResult result = run_program(command);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto files = nlohmann::json::parse(result.out);
    ASSERT_EQ(files.size(), kind.textures.size());
    for (std::size_t t = 0; t < kind.textures.size(); ++t) {
      const auto& [name, format] = kind.textures[t];
      const TexelFormatInfo& info = info_of(format);
      const auto& file = files[t];
      SCOPED_TRACE(name + " as " + info.name);
      EXPECT_EQ(file["vkFormat"], info.vk_format);
      EXPECT_EQ(file["typeSize"], is_half ? 2 : 1);
      EXPECT_EQ(file["size"], nlohmann::json::parse("[35, 22, 0]"));
      EXPECT_EQ(file["counts"], nlohmann::json::parse("[0, 1]"));
      EXPECT_EQ(file["supercompression"], kind.has_zstd ? 2 : 0);
      EXPECT_EQ(file["keys"]["KTXorientation"], "rd");
      EXPECT_EQ(file["keys"]["KTXwriter"].get<std::string>().rfind("multum ", 0), 0u);
      const std::string swizzle = file["keys"].value("KTXswizzle", "none");
      EXPECT_EQ(swizzle, info.channels == 4 ? "none" : info.channels == 2 ? "rg11" : "rrr1");
      ASSERT_EQ(file["descriptors"].size(), 1u);
      const auto& descriptor = file["descriptors"][0];
      const std::map<std::string, int> models = {{"BC4", 131}, {"BC5", 132}, {"BC7", 134}};  // KHR_DF_MODEL_BC4 ...
      EXPECT_EQ(descriptor["model"], models.count(info.name) > 0 ? models.at(info.name) : 1);
      EXPECT_EQ(descriptor["transfer"], 1);  // linear
      EXPECT_EQ(descriptor["block"],
                info.block_side == 4 ? nlohmann::json::parse("[3, 3, 0, 0]") : nlohmann::json::parse("[0, 0, 0, 0]"));
      EXPECT_EQ(descriptor["planes"][0], info.block_bytes);
      const int samples = format == TexelFormat::kBc7 ? 1 : info.channels, bits = 8 * info.block_bytes / samples;
      ASSERT_EQ(descriptor["samples"].size(), static_cast<std::size_t>(samples));
      for (int c = 0; c < samples; ++c) {
        const auto& sample = descriptor["samples"][static_cast<std::size_t>(c)];
        EXPECT_EQ(sample[0], bits * c);
        EXPECT_EQ(sample[1], bits - 1);
        EXPECT_EQ(sample[2], (c == 3 ? 15 : c) | (is_half ? 0xc0 : 0));
        EXPECT_EQ(sample[4], is_half ? 0x3f800000u : info.block_side == 4 ? 0xffffffffu : 255u);
      }
      ASSERT_EQ(file["levels"].size(), 6u);
      for (int l = 0; l < 6; ++l) {
        const auto& entry = file["levels"][static_cast<std::size_t>(l)];
        const auto decoded = decode_base64(entry["bytes"]);
        ASSERT_TRUE(decoded);
        std::string bytes(decoded->begin(), decoded->end());
        if (kind.has_zstd) {
          std::string plain(entry["length"].get<std::size_t>(), '\0');
          ASSERT_EQ(ZSTD_decompress(plain.data(), plain.size(), bytes.data(), bytes.size()), plain.size());
          bytes = plain;
        }
        EXPECT_EQ(entry["length"], bytes.size());
        if (info.block_side == 4) continue;  // a test below compares their texels
        const Picture image =
            level((name == "roughness" ? "orm" : name) + "_0" + std::to_string(l) + (is_half ? ".exr" : ".png"));
        const std::vector<float> texels = decoded_level(bytes, format, image.width, image.height);
        for (int i = 0; i < image.width * image.height; ++i)
          for (int c = 0; c < info.channels; ++c) {
            const std::size_t from = static_cast<std::size_t>(3 * i + (name == "roughness" ? 1 : c));
            ASSERT_NEAR(texels[static_cast<std::size_t>(4 * i + c)], c == 3 ? 1.0f : image.values[from], 1e-6f)
                << "level " << l << ", texel " << i << ", " << c;
          }
      }
    }
  }
}

// Compares every level of every kind of KTX2 file as three.js's KTX2Loader hands it to a shader in Chromium. Block
// formats are compared if the GL implementation of Chromium supports them.
TEST_F(ExportCommandTest, ThreeReadsTheLevels) {
  const std::string script = MULTUM_SOURCE_DIR "/tests/cli/exports/ktx2_in_three.mjs", browser = chromium_path();
  if (!program_works("node", "--version")) GTEST_SKIP() << "no node (Debian package nodejs)";
  if (browser.empty()) GTEST_SKIP() << "no chromium-headless-shell: tools/install_dependencies test";
  for (const std::string module : {"playwright-core", "three"})
    if (!std::filesystem::exists(MULTUM_SOURCE_DIR "/tests/service/web/node_modules/" + module))
      GTEST_SKIP() << "no " << module << ": tools/install_dependencies test";
  write("map.png", normal_image(36, 24));
  std::vector<std::string> command = {"node", script, browser};
  std::vector<std::pair<TexelFormat, std::string>> files;
  for (const Stored& kind : stored_kinds()) {
    const std::string folder = "out" + std::to_string(files.size());
    std::vector<std::string> options = {"export",       path("map.png"), "-o",      path(folder + "/rock.ktx2"),
                                        "--bumpformat", "normal",        "--green", "up",
                                        "--no-measure"};
    options.insert(options.end(), kind.options.begin(), kind.options.end());
    ASSERT_EQ(multum(options).exit_code, 0);
    // Repeats the export without Zstandard, for comparison.
    for (std::string& option : options)
      if (option == path(folder + "/rock.ktx2")) option = path(folder + "/plain.ktx2");
    if (kind.has_zstd) options.resize(options.size() - 2);
    ASSERT_EQ(multum(options).exit_code, 0);
    for (const auto& [name, format] : kind.textures) {
      command.push_back(path(folder + "/rock_" + name + ".ktx2"));
      files.emplace_back(format, read_bytes(path(folder + "/plain_" + name + ".ktx2")));
    }
  }
  const ProgramResult result = run_program(command);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto found = nlohmann::json::parse(result.out);
  const std::string extensions = found["extensions"].dump();
  const bool has_bc4 = extensions.find("EXT_texture_compression_rgtc") != std::string::npos,
             has_bc7 = extensions.find("EXT_texture_compression_bptc") != std::string::npos;
  std::printf("block compression in this GL: BC4 and BC5 %s, BC7 %s\n", has_bc4 ? "yes" : "no", has_bc7 ? "yes" : "no");
  EXPECT_TRUE(!has_bc4 || !has_bc7 || found["problems"].empty()) << found["problems"].dump();
  ASSERT_EQ(found["files"].size(), files.size());
  for (std::size_t f = 0; f < files.size(); ++f) {
    const auto& [format, bytes] = files[f];
    SCOPED_TRACE(std::string(info_of(format).name) + ", " + command[3 + f]);
    if (info_of(format).block_side == 4 && !(format == TexelFormat::kBc7 ? has_bc7 : has_bc4)) continue;
    const auto& file = found["files"][f];
    ASSERT_FALSE(file.contains("error")) << file["error"];
    EXPECT_EQ(file["isCompressed"], info_of(format).block_side == 4);
    EXPECT_FALSE(file["generateMipmaps"]);
    EXPECT_FALSE(file["flipY"]);
    EXPECT_FALSE(file["hasColours"]);
    ASSERT_EQ(file["levels"].size(), 6u);
    for (int l = 0; l < 6; ++l) {
      const auto& level_found = file["levels"][static_cast<std::size_t>(l)];
      const int width = std::max(1, 36 >> l), height = std::max(1, 24 >> l);
      EXPECT_EQ(level_found["width"], width);
      EXPECT_EQ(level_found["height"], height);
      const auto texels = decode_base64(level_found["texels"]);
      ASSERT_TRUE(texels);
      const std::vector<float> expected = decoded_level(level_of(bytes, format, 36, 24, l), format, width, height);
      ASSERT_EQ(texels->size(), expected.size() * sizeof(float));
      // GL implementations may round interpolated values of BC4 and BC5 blocks to 8 bits.
      const float tolerance = format == TexelFormat::kBc4 || format == TexelFormat::kBc5 ? 1.01f / 255.0f : 1e-6f;
      for (std::size_t i = 0; i < expected.size(); ++i) {
        float value;
        std::memcpy(&value, texels->data() + i * sizeof(float), sizeof(float));
        ASSERT_NEAR(value, expected[i], tolerance) << "level " << l << ", value " << i;
      }
    }
  }
}

// OpenImageIO decodes the compressed blocks of DDS files. It does not support other formats with a DX10 header, so the
// bytes of those levels are compared with the KTX2 file.
TEST_F(ExportCommandTest, OpenImageIoReadsDds) {
  write("map.png", normal_image(36, 24));
  for (const Stored& kind : stored_kinds()) {
    if (kind.has_zstd) continue;
    for (const std::string extension : {"ktx2", "dds"}) {
      std::vector<std::string> options = {"export",       path("map.png"), "-o",      path("rock." + extension),
                                          "--bumpformat", "normal",        "--green", "up",
                                          "--no-measure"};
      options.insert(options.end(), kind.options.begin(), kind.options.end());
      ASSERT_EQ(multum(options).exit_code, 0);
    }
    for (const auto& [name, format] : kind.textures) {
      const std::string file = path("rock_" + name + ".dds");
      const std::string bytes = read_bytes(file), ktx2 = read_bytes(path("rock_" + name + ".ktx2"));
      const TexelFormatInfo& info = info_of(format);
      SCOPED_TRACE(name + " as " + info.name);
      const auto input = info.block_side == 4 ? OIIO::ImageInput::open(file) : nullptr;
      EXPECT_EQ(input != nullptr, info.block_side == 4) << OIIO::geterror();
      for (int l = 0; l < 6; ++l) {
        const int width = std::max(1, 36 >> l), height = std::max(1, 24 >> l);
        const std::string own = level_of(bytes, format, 36, 24, l);
        EXPECT_EQ(own, level_of(ktx2, format, 36, 24, l));
        if (!input) continue;
        ASSERT_TRUE(input->seek_subimage(0, l));
        EXPECT_EQ(input->spec().width, width);
        EXPECT_EQ(input->spec().height, height);
        ASSERT_EQ(input->spec().nchannels, info.channels);
        std::vector<float> values(static_cast<std::size_t>(info.channels * width * height));
        ASSERT_TRUE(input->read_image(0, l, 0, info.channels, OIIO::TypeDesc::FLOAT, values.data()));
        const std::vector<float> expected = decoded_level(own, format, width, height);
        for (std::size_t i = 0; i < values.size(); ++i) {
          const auto channels = static_cast<std::size_t>(info.channels);
          ASSERT_NEAR(values[i], expected[i / channels * 4 + i % channels], 1.01f / 255.0f) << "level " << l;
        }
      }
      EXPECT_FALSE(input && input->seek_subimage(0, 6));
    }
  }
}

// Errors are measured on decoded blocks, with z computed as in a shader. In this rough map, the normals of one block
// differ greatly.
TEST_F(ExportCommandTest, MeasuresWhatIsStored) {
  make_map("big", 128);
  std::map<std::string, double> errors;
  for (const std::string texels : {"rgba8", "rg8", "bc"}) {
    ASSERT_EQ(multum({"export", path("big_normal.png"), "-o", path(texels + ".ktx2"), "--texels", texels, "--report",
                      path("r.json"), "--base-roughness", "0.3"})
                  .exit_code,
              0);
    const auto report = nlohmann::json::parse(read_bytes(path("r.json")));
    errors[texels] = report["accuracy"]["levels"][0]["rules"]["export"]["error"];
    EXPECT_TRUE(report["side_warnings"].empty());
  }
  EXPECT_NE(errors["rg8"], errors["rgba8"]);
  EXPECT_NE(errors["bc"], errors["rg8"]);
  EXPECT_NEAR(errors["rg8"], errors["rgba8"], 0.02 * errors["rgba8"]);
  EXPECT_GT(errors["bc"], errors["rgba8"]);
  EXPECT_NEAR(errors["bc"], errors["rgba8"], 0.4 * errors["rgba8"]);
}

// Level 0 of a baked file is the map; the report also measures the file's lobes.
TEST_F(ExportCommandTest, TakesABakedFile) {
  make_map("big", 128);
  for (const std::string ndf : {"vmf", "gmm"})
    ASSERT_EQ(
        multum({"bake", path("big_normal.png"), "-o", path(ndf + ".ndf.exr"), "--ndf", ndf, "--no-measure"}).exit_code,
        0);
  std::map<std::string, nlohmann::json> reports;
  const auto exported = [&](const std::string& input, const std::string& name, std::vector<std::string> more) {
    more.insert(more.begin(),
                {"export", path(input), "-o", path(name), "--report", path(name + ".json"), "--base-roughness", "0.3"});
    const ProgramResult result = multum(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    reports[name] = nlohmann::json::parse(read_bytes(path(name + ".json")));
  };
  exported("big_normal.png", "map", {"--beside", path("vmf.ndf.exr")});
  exported("vmf.ndf.exr", "vmf", {});
  exported("gmm.ndf.exr", "gmm", {"--memory", "200K"});
  for (const std::string other : {"vmf", "gmm"})
    for (const char* texture : {"normal_0", "orm_0"})
      for (int l = 0; l < 8; ++l) {
        const std::string name = texture + std::to_string(l) + ".png";
        const Picture expected = read_picture(path("map/" + name)), found = read_picture(path(other + "/" + name));
        ASSERT_EQ(found.values.size(), expected.values.size());
        for (std::size_t i = 0; i < expected.values.size(); ++i)
          ASSERT_NEAR(found.values[i], expected.values[i], 1.5f / 255.0f) << other << " " << name << " " << i;
      }
  const auto rule = [&](const std::string& name, const char* id) {
    return reports[name]["accuracy"]["levels"][1]["rules"][id]["error"].get<double>();
  };
  EXPECT_LT(rule("map", "baked"), 0.6 * rule("map", "export"));
  EXPECT_GT(rule("map", "baked"), 0.0);
  EXPECT_NEAR(rule("vmf", "baked"), rule("map", "baked"), 0.01);
  EXPECT_FALSE(reports["gmm"]["accuracy"]["levels"][1]["rules"].contains("baked"));
  EXPECT_EQ(reports["map"]["accuracy"]["names"]["baked"], "4 baked lobes");
}

// The page shows every way of filtering, with pictures and numbers. Lobes have the lowest error and the least flicker.
TEST_F(ExportCommandTest, WritesAPage) {
  make_map("big", 128);
  const ProgramResult result = multum({"export", path("big_normal.png"), "-o", path("out"), "--base-roughness", "0.3",
                                       "--page", path("page.html"), "--cells", "2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string page = read_bytes(path("page.html"));
  const auto begin = page.find('{', page.find("id=\"data\"")), end = page.find("</script", begin);
  const auto data = nlohmann::json::parse(page.substr(begin, end - begin));
  ASSERT_EQ(data["distances"].size(), 3u);
  for (const auto& distance : data["distances"]) {
    EXPECT_EQ(distance["pictures"].size(), 9u);
    EXPECT_EQ(decode_base64(distance["pictures"]["reference"])->substr(1, 3), "PNG");
    const auto& models = distance["models"];
    EXPECT_LT(models["baked"]["error"], models["isotropic"]["error"]);
    EXPECT_LT(models["isotropic"]["error"], models["averaged"]["error"]);
    EXPECT_NEAR(models["isotropic"]["energy"].get<double>(), 1.0, 0.15);
  }
  for (const auto& motion : data["motions"]) {
    EXPECT_LT(motion["models"]["baked"]["flicker"], motion["models"]["averaged"]["flicker"]) << motion["id"];
    EXPECT_LT(motion["models"]["isotropic"]["flicker"], motion["models"]["averaged"]["flicker"]) << motion["id"];
    EXPECT_GT(motion["reference_change"], 0.0);
  }
  EXPECT_EQ(data["report"]["accuracy"]["names"]["baked"], "4 baked lobes");
  EXPECT_TRUE(data["report"]["launches"].contains("one_lobe_fit"));
  EXPECT_FALSE(data["report"]["launches"].contains("movmf_em_texels"))
      << "launches of the page's bake must not count for the export";
  if (program_works("ffmpeg", "-version")) EXPECT_EQ(decode_base64(data["video"])->substr(0, 4), "\x1a\x45\xdf\xa3");
  else expect_says(result.err, {"ffmpeg", "no moving pictures"});
  // The export, the page and the bake of lobes each read the map, but the message about the map is printed only once.
  std::istringstream said(result.err);
  std::set<std::string> lines;
  for (std::string line; std::getline(said, line);) EXPECT_TRUE(lines.insert(line).second) << line;
  EXPECT_FALSE(lines.empty());
  // No other file is left in the folder.
  for (const auto& entry : std::filesystem::directory_iterator(path("")))
    EXPECT_FALSE(entry.path().filename().string().starts_with(".multum")) << entry.path();
  expect_refusal(multum({"export", path("big_normal.png"), "-o", path("new"), "--page", "/proc/none/page.html"}),
                 kEnvironment, {"none"});
  EXPECT_FALSE(std::filesystem::exists(path("new")));
}

TEST_F(ExportCommandTest, RefusesBakedFilesThatItCannotUse) {
  make_map("big", 64);
  const std::string map = path("big_normal.png");
  write("rough.png", normal_image(64, 64));
  const auto baked = [&](const std::string& name, std::vector<std::string> more) {
    more.insert(more.begin(), {"bake", map, "-o", path(name), "--no-measure"});
    EXPECT_EQ(multum(more).exit_code, 0) << name;
  };
  baked("moments.ndf.exr", {"--ndf", "moments"});
  baked("rough.ndf.exr", {"--roughness", path("rough.png")});
  baked("coarse.ndf.exr", {"--first-level", "3"});
  baked("gmm.ndf.exr", {"--ndf", "gmm"});
  const auto refused = [&](const std::string& input, std::vector<std::string> more, int code,
                           const std::vector<std::string>& parts) {
    more.insert(more.begin(), {"export", path(input), "-o", path("out")});
    expect_refusal(multum(more), code, parts);
    EXPECT_TRUE(!std::filesystem::exists(path("out")) || std::filesystem::is_empty(path("out"))) << input;
  };
  refused("moments.ndf.exr", {}, kInput, {"moments.ndf.exr", "lobes"});
  refused("rough.ndf.exr", {}, kInput, {"rough.ndf.exr", "--roughness"});
  refused("coarse.ndf.exr", {}, kInput, {"coarse.ndf.exr", "finer than 3", "--first-level 0"});
  refused("gmm.ndf.exr", {"--green", "up"}, kUsage, {"gmm.ndf.exr", "--green"});
  refused("big_normal.png", {"--beside", path("gmm.ndf.exr")}, kInput, {"gmm.ndf.exr", "vMF lobes"});
  refused("big_normal.png", {"--beside", path("coarse.ndf.exr")}, kInput, {"coarse.ndf.exr", "level 2"});
  refused("big_normal.png", {"--beside", path("none.ndf.exr")}, kInput, {"none.ndf.exr"});
  refused("big_normal.png", {"--beside", path("gmm.ndf.exr"), "--no-measure"}, kUsage, {"--beside", "--no-measure"});
  baked("fine.ndf.exr", {});
  refused("rough.png", {"--beside", path("fine.ndf.exr")}, kInput, {"fine.ndf.exr", "another map"});
  write("rough.png", normal_image(16, 16));
  refused("rough.png", {"--beside", path("fine.ndf.exr")}, kInput, {"fine.ndf.exr", "64 x 64", "16 x 16"});
  std::ofstream(path("broken.ndf.exr")) << "no file of OpenEXR";
  refused("broken.ndf.exr", {}, kInput, {"broken.ndf.exr"});
}

TEST_F(ExportCommandTest, IsTheSameForAnyMemoryAndThreads) {
  write("map.png", normal_image(150, 90));
  const auto files = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--anisotropy", "--no-measure"});
    EXPECT_EQ(run(more).exit_code, 0);
    more.insert(more.end(), {"--format", "ktx2", "--texels", "bc", "--zstd", "5"});
    EXPECT_EQ(run(more).exit_code, 0);
    std::map<std::string, std::string> bytes;
    for (const auto& entry : std::filesystem::directory_iterator(path("out")))
      bytes[entry.path().filename().string()] = read_bytes(entry.path().string());
    std::filesystem::remove_all(path("out"));
    return bytes;
  };
  const auto plain = files({});
  EXPECT_EQ(plain.size(), 24u + 3u);
  EXPECT_EQ(files({"--memory", "200K", "--threads", "1"}), plain);
  EXPECT_NE(files({"--fast"}), plain);
  EXPECT_NE(files({"--base-roughness", "0.4"}), plain);
}

TEST_F(ExportCommandTest, RefusesWhatCannotBe) {
  write("map.png", normal_image(16, 16));
  write("small.png", normal_image(8, 8));
  TestImage loud{.width = 16, .height = 16, .channels = 1, .type = OIIO::TypeDesc::FLOAT};
  loud.values.assign(256, 1.5f);
  write("loud.exr", loud);
  expect_refused({"--base-roughness", "1.5"}, kUsage, {"--base-roughness", "1.5", "0 to 1"});
  expect_refused({"--base-roughness", "0.3", "--roughness", path("small.png")}, kUsage, {"--roughness"});
  expect_refused({"--optimum", "--no-measure"}, kUsage, {"--optimum"});
  expect_refused({"--cells", "0"}, kUsage, {"--cells", "0"});
  expect_refused({"--format", "jpg"}, kUsage, {"--format", "jpg"});
  expect_refused({"--roughness", path("small.png")}, kInput, {"small.png", "8 x 8", "16 x 16"});
  expect_refused({"--metalness", path("loud.exr")}, kInput, {"loud.exr", "1.5", "a metalness map"});
  expect_refused({"--occlusion", path("map.png") + ":Q"}, kInput, {"map.png", "no channel Q"});
  expect_refused({"--memory", "1K"}, kUsage, {"--memory"});
  expect_refused({"--scratch", path("none")}, kEnvironment, {"none", "scratch"});
  expect_refused({"--report", path("map.png")}, kUsage, {"map.png"});
  expect_refused({"--report", "/proc/no/r.json"}, kEnvironment, {"no"});
  expect_refusal(multum({"export", path("none.png"), "-o", path("out")}), kInput, {"none.png"});
  expect_refused({"--format", "ktx2-half"}, kUsage, {"--format", "ktx2-half"});
  expect_refused({"--texels", "bc"}, kUsage, {"--texels", "--format ktx2"});
  expect_refused({"--format", "exr", "--texels", "rgba8"}, kUsage, {"--texels", "half floats"});
  expect_refused({"--zstd", "3"}, kUsage, {"--zstd", "KTX2"});
  expect_refused({"--zstd", "20", "--format", "ktx2"}, kUsage, {"--zstd", "20", "19"});
  expect_refused({"--packing", "rma"}, kUsage, {"--packing", "rma", "orm"});
  expect_refusal(multum({"export", path("map.png"), "-o", path("a.png")}), kUsage, {"a.png", "a folder", "NAME.ktx2"});
  expect_refusal(multum({"export", path("map.png"), "-o", path("a.dds"), "--format", "ktx2"}), kUsage,
                 {"a.dds", "--format"});
  expect_refusal(multum({"export", path("map.png"), "-o", path("map.png/a.dds")}), kEnvironment, {"map.png"});
  expect_refusal(multum({"export", path("map.png"), "-o", path("map.png/out")}), kEnvironment, {"map.png"});
  expect_refusal(multum({"export", path("map.png")}), kUsage, {"--output"});
  // The output folder contains the source map, which has the name of an output file.
  std::filesystem::create_directory(path("own"));
  write("own/normal_00.png", normal_image(16, 16));
  const std::string before = read_bytes(path("own/normal_00.png"));
  expect_refusal(multum({"export", path("own/normal_00.png"), "-o", path("own")}), kUsage, {"normal_00.png"});
  EXPECT_EQ(read_bytes(path("own/normal_00.png")), before);
}

TEST_F(ExportCommandTest, LeavesNothingWhereItIsInterrupted) {
  make_map("big", 512);
  Program program(
      multum_command({"export", path("big_normal.png"), "-o", path("out"), "--optimum", "--cells", "4096"}));
  const auto has_files = [&] {
    std::error_code error;
    return std::filesystem::exists(path("out"), error) && !std::filesystem::is_empty(path("out"), error);
  };
  while (program.running() && !has_files()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_FALSE(has_files());
}

}  // namespace
}  // namespace multum::testing
