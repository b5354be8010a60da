// SPDX-License-Identifier: Apache-2.0
// Tests multum export for engines with other conventions: green down, smoothness, no metalness, and UASTC. Also tests
// the message about engines that cannot load any of the files. OpenImageIO reads images and DDS blocks; three.js reads
// UASTC in Chromium.
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/delivery/export/engines/engine_support.h"
#include "host/foundation/base/base64.h"
#include "tests/cli/exports/exported_levels.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

const std::string kModules = MULTUM_SOURCE_DIR "/tests/service/web/node_modules/";

// Holds one level of a texture, with four values per texel.
using Texels = std::vector<float>;

class ExportEnginesTest : public CliTest {
 protected:
  static constexpr int kWidth = 36, kHeight = 24, kLevels = 6;

  void SetUp() override { write_test_image(path("map.png"), normal_image(kWidth, kHeight)); }

  ProgramResult run(const std::string& output, std::vector<std::string> more) const {
    more.insert(more.begin(), {"export", path("map.png"), "-o", path(output), "--bumpformat", "normal", "--green", "up",
                               "--no-measure"});
    return multum(more);
  }
  void expect_done(const std::string& output, const std::vector<std::string>& more) const {
    const ProgramResult result = run(output, more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  Picture image(const std::string& output, const std::string& texture, int level, const std::string& extension) const {
    return read_picture(path(output + "/" + texture + "_0" + std::to_string(level) + "." + extension));
  }
  Texels stored(const std::string& file, TexelFormat format, int level) const {
    const std::string bytes = level_of(read_bytes(path(file)), format, kWidth, kHeight, level);
    return decoded_level(bytes, format, std::max(1, kWidth >> level), std::max(1, kHeight >> level));
  }
  // Reads a level's blocks as OpenImageIO decodes them.
  Picture dds_level(const std::string& file, int level) const {
    OIIO::ImageSpec as_stored;
    as_stored.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(path(file), &as_stored);
    EXPECT_NE(input, nullptr) << OIIO::geterror();
    Picture picture;
    if (!input || !input->seek_subimage(0, level)) return picture;
    picture.width = input->spec().width;
    picture.height = input->spec().height;
    picture.channels = input->spec().nchannels;
    picture.values.resize(static_cast<std::size_t>(picture.width * picture.height * picture.channels));
    EXPECT_TRUE(input->read_image(0, level, 0, picture.channels, OIIO::TypeDesc::FLOAT, picture.values.data()));
    return picture;
  }
};

TEST_F(ExportEnginesTest, GreenDownIsTheOtherWayRoundInImages) {
  for (const std::string format : {"png", "exr"}) {
    expect_done("up_" + format, {"--format", format, "--anisotropy"});
    expect_done("down_" + format, {"--format", format, "--anisotropy", "--write-green", "down"});
    expect_done("said_" + format, {"--format", format, "--anisotropy", "--write-green", "up"});
    const float sum = format == "png" ? 1.0f : 0.0f;  // the sum of a value and its negative
    for (const std::string texture : {"normal", "anisotropy", "orm"})
      for (int l = 0; l < kLevels; ++l) {
        SCOPED_TRACE(texture + ", level " + std::to_string(l) + ", " + format);
        const Picture up = image("up_" + format, texture, l, format),
                      down = image("down_" + format, texture, l, format);
        EXPECT_EQ(image("said_" + format, texture, l, format).values, up.values);
        ASSERT_EQ(down.values.size(), up.values.size());
        for (std::size_t i = 0; i < up.values.size(); ++i)
          ASSERT_NEAR(down.values[i], i % 3 == 1 && texture != "orm" ? sum - up.values[i] : up.values[i], 1e-6f) << i;
      }
  }
  // The map is steep enough to show the difference.
  EXPECT_GT(std::abs(image("up_png", "normal", 0, "png").at(3, 4, 1) - 0.5f), 0.02f);
}

TEST_F(ExportEnginesTest, GreenDownIsTheOtherWayRoundInTextureFiles) {
  const struct {
    std::string texels;
    TexelFormat normal;
    float sum, tolerance;
  } kinds[] = {{"rgba8", TexelFormat::kRgba8, 1.0f, 1e-6f},
               {"rg8", TexelFormat::kRg8, 1.0f, 1e-6f},
               {"rgba16f", TexelFormat::kRgba16f, 0.0f, 1e-6f},
               {"bc", TexelFormat::kBc5, 1.0f, 0.06f}};
  for (const auto& kind : kinds)
    for (const std::string extension : {"ktx2", "dds"}) {
      SCOPED_TRACE(kind.texels + ", " + extension);
      expect_done("up." + extension, {"--texels", kind.texels});
      expect_done("down." + extension, {"--texels", kind.texels, "--write-green", "down"});
      for (int l = 0; l < kLevels; ++l) {
        const Texels up = stored("up_normal." + extension, kind.normal, l),
                     down = stored("down_normal." + extension, kind.normal, l);
        for (std::size_t i = 0; i < up.size(); ++i)
          ASSERT_NEAR(down[i], i % 4 == 1 ? kind.sum - up[i] : up[i], kind.tolerance) << "level " << l << ", " << i;
      }
    }
  // OpenImageIO decodes BC5. The green channel of level 0 is the inverted green channel of the map.
  const Picture blocks = dds_level("down_normal.dds", 0), map = read_picture(path("map.png"));
  float error = 0.0f;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) error += std::abs(blocks.at(x, y, 1) + map.at(x, y, 1) - 1.0f);
  EXPECT_LT(error / static_cast<float>(kWidth * kHeight), 0.01f);
}

// The measured error does not depend on the direction of green.
TEST_F(ExportEnginesTest, MeasuresTheSameWithGreenDown) {
  make_map("big", 64);
  std::map<std::string, nlohmann::json> reports;
  for (const std::string green : {"up", "down"}) {
    ASSERT_EQ(multum({"export", path("big_normal.png"), "-o", path(green + ".ktx2"), "--texels", "bc", "--write-green",
                      green, "--report", path("r.json")})
                  .exit_code,
              0);
    reports[green] = nlohmann::json::parse(read_bytes(path("r.json")));
    EXPECT_EQ(reports[green]["green"], green);
  }
  const auto error = [&](const std::string& green) {
    return reports[green]["accuracy"]["levels"][0]["rules"]["export"]["error"].get<double>();
  };
  EXPECT_NEAR(error("down"), error("up"), 0.05 * error("up"));
}

// Unity's mask map has metalness in red, occlusion in green, detail in blue and smoothness in alpha.
TEST_F(ExportEnginesTest, SmoothnessIsInTheMasksAlpha) {
  TestImage maps{.width = kWidth, .height = kHeight, .channels = 3};
  for (int i = 0; i < kWidth * kHeight; ++i)
    for (const double value : {0.25, 0.2 + 0.6 * (i % kWidth) / kWidth, i % kWidth < kWidth / 2 ? 0.0 : 1.0})
      maps.values.push_back(static_cast<float>(value));
  write_test_image(path("maps.png"), maps);
  std::vector<std::string> more = {"--roughness", path("maps.png"), "--occlusion", path("maps.png"),
                                   "--metalness", path("maps.png"), "--format"};
  const auto with = [&](std::vector<std::string> last) {
    std::vector<std::string> all = more;
    all.insert(all.end(), last.begin(), last.end());
    return all;
  };
  for (const std::string format : {"png", "exr"}) {
    expect_done("orm", with({format}));
    expect_done("mask", with({format, "--packing", "mask"}));
    EXPECT_FALSE(std::filesystem::exists(path("mask/orm_00." + format)));
    for (int l = 0; l < kLevels; ++l) {
      const Picture orm = image("orm", "orm", l, format), mask = image("mask", "mask", l, format);
      ASSERT_EQ(mask.channels, 4);
      for (int y = 0; y < orm.height; ++y)
        for (int x = 0; x < orm.width; ++x) {
          EXPECT_NEAR(mask.at(x, y, 0), orm.at(x, y, 2), 1e-6f);
          EXPECT_NEAR(mask.at(x, y, 1), orm.at(x, y, 0), 1e-6f);
          EXPECT_EQ(mask.at(x, y, 2), 1.0f);
          EXPECT_NEAR(mask.at(x, y, 3), 1.0f - orm.at(x, y, 1), format == "png" ? 1e-6f : 5e-4f);
        }
    }
    std::filesystem::remove_all(path("mask"));
  }
  // Compares the roughness in blocks with alpha, as OpenImageIO decodes them, with the roughness of the images.
  expect_done("orm", with({"png"}));
  expect_done("blocks.dds", with({"dds", "--packing", "mask", "--texels", "bc"}));
  for (int l = 0; l < kLevels; ++l) {
    const Picture orm = image("orm", "orm", l, "png"), mask = dds_level("blocks_mask.dds", l);
    ASSERT_EQ(mask.channels, 4);
    float error = 0.0f;
    for (int y = 0; y < orm.height; ++y)
      for (int x = 0; x < orm.width; ++x) {
        error += std::abs(mask.at(x, y, 3) + orm.at(x, y, 1) - 1.0f);
        ASSERT_NEAR(mask.at(x, y, 0), orm.at(x, y, 2), 0.1f) << "level " << l;
        ASSERT_NEAR(mask.at(x, y, 1), orm.at(x, y, 0), 0.05f) << "level " << l;
        ASSERT_NEAR(mask.at(x, y, 2), 1.0f, 0.01f) << "level " << l;
      }
    EXPECT_LT(error / static_cast<float>(orm.width * orm.height), 0.02f) << "level " << l;
  }
  // Here roughness is a texture of its own.
  expect_done("alone", {"--roughness", path("maps.png"), "--metalness", path("maps.png"), "--packing", "smoothness"});
  const Picture orm = image("orm", "orm", 1, "png"), alone = image("alone", "smoothness", 1, "png");
  for (int x = 0; x < alone.width; ++x) EXPECT_NEAR(alone.at(x, 2, 0), 1.0f - orm.at(x, 2, 1), 1e-6f);
}

// Without a metalness map the metalness is 0.
TEST_F(ExportEnginesTest, WithoutAMetalnessMapNothingIsMetal) {
  expect_done("orm", {});
  expect_done("mask", {"--packing", "mask"});
  expect_done("half.ktx2", {"--texels", "rgba16f"});
  for (int l = 0; l < kLevels; ++l) {
    const Picture orm = image("orm", "orm", l, "png"), mask = image("mask", "mask", l, "png");
    EXPECT_EQ(orm.at(0, 0, 2), 0.0f);
    EXPECT_EQ(orm.at(0, 0, 0), 1.0f);
    EXPECT_EQ(mask.at(0, 0, 0), 0.0f);
    EXPECT_EQ(mask.at(0, 0, 1), 1.0f);
    EXPECT_EQ(stored("half_orm.ktx2", TexelFormat::kRgba16f, l)[2], 0.0f);
  }
}

// With and without Zstandard, the texels that three.js passes to a shader equal the images' levels, except for the loss
// of UASTC blocks.
TEST_F(ExportEnginesTest, ThreeReadsUastc) {
  const std::string script = MULTUM_SOURCE_DIR "/tests/cli/exports/ktx2_in_three.mjs", browser = chromium_path();
  if (!program_works("node", "--version")) GTEST_SKIP() << "no node (Debian package nodejs)";
  if (browser.empty()) GTEST_SKIP() << "no chromium-headless-shell: tools/install_dependencies test";
  for (const std::string module : {"playwright-core", "three", "ktx2-encoder"})
    if (!std::filesystem::exists(kModules + module)) GTEST_SKIP() << "no " << module;
  const std::vector<std::string> uastc = {"--format", "ktx2", "--texels", "uastc", "--encoder", kModules};
  const auto with = [&](std::vector<std::string> last) {
    last.insert(last.begin(), uastc.begin(), uastc.end());
    return last;
  };
  expect_done("plain", with({"--anisotropy"}));
  expect_done("packed", with({"--packing", "mask", "--zstd", "5"}));
  expect_done("images", {"--anisotropy"});
  expect_done("masks", {"--packing", "mask"});
  const std::pair<std::string, std::string> files[] = {
      {"plain", "normal"}, {"plain", "orm"}, {"plain", "anisotropy"}, {"packed", "mask"}};
  std::vector<std::string> command = {"node", script, browser};
  for (const auto& [folder, texture] : files) command.push_back(path(folder + "/" + texture + ".ktx2"));
  const ProgramResult result = run_program(command);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto found = nlohmann::json::parse(result.out)["files"];
  for (std::size_t f = 0; f < std::size(files); ++f) {
    const std::string& texture = files[f].second;
    SCOPED_TRACE(texture);
    ASSERT_FALSE(found[f].contains("error")) << found[f]["error"];
    ASSERT_EQ(found[f]["levels"].size(), static_cast<std::size_t>(kLevels));
    for (int l = 0; l < kLevels; ++l) {
      const Picture expected = image(texture == "mask" ? "masks" : "images", texture, l, "png");
      const auto bytes = decode_base64(found[f]["levels"][static_cast<std::size_t>(l)]["texels"]);
      Texels texels(static_cast<std::size_t>(4 * expected.width * expected.height));
      ASSERT_TRUE(bytes && bytes->size() == texels.size() * sizeof(float));
      std::memcpy(texels.data(), bytes->data(), bytes->size());
      float error = 0.0f;
      for (std::size_t i = 0; i < texels.size() / 4; ++i)
        for (std::size_t c = 0; c < static_cast<std::size_t>(expected.channels); ++c)
          error += std::abs(texels[4 * i + c] - expected.values[i * static_cast<std::size_t>(expected.channels) + c]);
      // Axes of anisotropy differ greatly between neighbouring texels.
      EXPECT_LT(error / static_cast<float>(expected.values.size()), texture == "anisotropy" ? 0.06f : 0.03f)
          << "level " << l;
    }
  }
}

// The error is measured on the stored blocks.
TEST_F(ExportEnginesTest, MeasuresUastcAsItIsStored) {
  if (!program_works("node", "--version")) GTEST_SKIP() << "no node (Debian package nodejs)";
  if (!std::filesystem::exists(kModules + "ktx2-encoder")) GTEST_SKIP() << "no ktx2-encoder";
  make_map("big", 64);
  std::map<std::string, double> errors;
  for (const std::string texels : {"rgba8", "uastc"}) {
    const ProgramResult result =
        multum({"export", path("big_normal.png"), "-o", path(texels + ".ktx2"), "--texels", texels, "--encoder",
                kModules, "--report", path("r.json"), "--base-roughness", "0.3"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto report = nlohmann::json::parse(read_bytes(path("r.json")));
    errors[texels] = report["accuracy"]["levels"][0]["rules"]["export"]["error"];
  }
  EXPECT_GT(errors["uastc"], 1.02 * errors["rgba8"]);
  EXPECT_LT(errors["uastc"], 1.8 * errors["rgba8"]);
}

TEST_F(ExportEnginesTest, RefusesUastcThatItCannotWrite) {
  expect_refusal(run("out", {"--texels", "uastc"}), kUsage, {"--texels", "--format ktx2"});
  expect_refusal(run("out.dds", {"--texels", "uastc"}), kUsage, {"--texels", "uastc", "ktx2"});
  std::filesystem::create_directory(path("none"));
  expect_refusal(run("new/out.ktx2", {"--texels", "uastc", "--encoder", path("none")}), kEnvironment,
                 {"--texels uastc", "ktx2-encoder", "--encoder", "--texels rgba8"});
  EXPECT_FALSE(std::filesystem::exists(path("new")));
  expect_refusal(run("out", {"--write-green", "left"}), kUsage, {"--write-green", "left"});
  EXPECT_FALSE(std::filesystem::exists(path("out")));
  for (const auto& entry : std::filesystem::directory_iterator(path("")))
    EXPECT_FALSE(entry.path().filename().string().starts_with(".multum")) << entry.path();
}

// Manifests have keys for the same settings, and an export notices when these keys change.
TEST_F(ExportEnginesTest, ManifestsHaveThem) {
  const auto with = [&](const std::string& keys) {
    write_bytes(path("maps.toml"),
                "[[map]]\ninput = \"map.png\"\noutput = \"out\"\nbumpformat = \"normal\"\n"
                "green = \"up\"\n" +
                    keys);
    return path("maps.toml");
  };
  const std::string manifest = with("write_green = \"down\"\npacking = \"mask\"\n");
  const ProgramResult first = multum({"export", "--manifest", manifest, "--no-measure"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(first.out.find("Unreal"), std::string::npos) << "it was measured: " << first.out;
  expect_done("direct", {"--write-green", "down", "--packing", "mask"});
  for (const char* texture : {"normal", "mask"})
    EXPECT_EQ(image("out", texture, 1, "png").values, image("direct", texture, 1, "png").values);
  expect_says(multum({"export", "--manifest", manifest, "--no-measure"}).out, {"0 exported, 1 unchanged"});
  expect_says(multum({"export", "--manifest", manifest, "--no-measure", "--force"}).out, {"1 exported, 0 unchanged"});
  with("packing = \"mask\"\n");
  const ProgramResult stale = multum({"export", "--manifest", manifest, "--check", "--dry-run"});
  EXPECT_EQ(stale.exit_code, kVerification);
  expect_says(stale.err, {"stale", "write_green"});
}

// The export prints one line that says what to do. It prints nothing if every engine loads the files.
TEST_F(ExportEnginesTest, SaysWhichEnginesLoadNothing) {
  const ProgramResult bytes = run("bytes.ktx2", {});
  expect_says(bytes.out, {"bytes.ktx2: known not to load: Babylon.js, PlayCanvas, Filament", "--texels uastc"});
  EXPECT_EQ(bytes.out.find("three.js"), std::string::npos);
  expect_says(run("blocks.dds", {"--texels", "bc"}).out, {"known not to load: three.js, Babylon.js", "--texels uastc"});
  EXPECT_EQ(run("images", {}).out.find("known not to load"), std::string::npos);
  EXPECT_EQ(run("bytes.ktx2", {"--quiet"}).out, "");
  const std::vector<std::string> of_uastc = engines_that_fail(MaterialFormat::kKtx2, MaterialTexels::kUastc);
  EXPECT_EQ(std::count(of_uastc.begin(), of_uastc.end(), "Babylon.js"), 0);
}

}  // namespace
}  // namespace multum::testing
