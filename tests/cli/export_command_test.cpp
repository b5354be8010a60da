// SPDX-License-Identifier: Apache-2.0
// multum export: its images as OpenImageIO reads them, the same for any memory, its report, what is refused, and what
// is left where it is interrupted.
#include <OpenImageIO/imageio.h>

#include <signal.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/base/base64.h"
#include "host/base/half_bits.h"
#include "tests/cli/program.h"
#include "tests/unit/image/image_test_files.h"

namespace multum::testing {
namespace {

struct Picture {
  int width = 0, height = 0, channels = 0;
  bool is_half = false;
  std::string colour_space;
  std::vector<float> values;

  float at(int x, int y, int c) const { return values[static_cast<std::size_t>((y * width + x) * channels + c)]; }
};

Picture read_picture(const std::string& path) {
  Picture picture;
  const auto file = OIIO::ImageInput::open(path);
  EXPECT_NE(file, nullptr) << path;
  if (!file) return picture;
  picture.width = file->spec().width;
  picture.height = file->spec().height;
  picture.channels = file->spec().nchannels;
  picture.is_half = file->spec().format == OIIO::TypeDesc::HALF;
  picture.values.resize(static_cast<std::size_t>(picture.width * picture.height * picture.channels));
  EXPECT_TRUE(file->read_image(0, 0, 0, picture.channels, OIIO::TypeDesc::FLOAT, picture.values.data()));
  return picture;
}

class ExportCommandTest : public CliTest {
 protected:
  ProgramResult run(std::vector<std::string> more) const {
    more.insert(more.begin(),
                {"export", path("map.png"), "-o", path("out"), "--bumpformat", "normal", "--green", "up"});
    return multum(more);
  }
  void expect_refused(const std::vector<std::string>& more, int code, const std::vector<std::string>& parts) const {
    expect_refusal(run(more), code, parts);
    EXPECT_TRUE(!std::filesystem::exists(path("out")) || std::filesystem::is_empty(path("out"))) << parts[0];
  }
  Picture level(const std::string& name) const { return read_picture(path("out/" + name)); }
  void write(const std::string& name, const TestImage& image) const { write_test_image(path(name), image); }
};

TEST_F(ExportCommandTest, OpenImageIoReadsTheLevels) {
  write("map.png", normal_image(35, 22));
  const ProgramResult result =
      run({"--anisotropy", "--base-roughness", "0.2", "--report", path("r.json"), "--cells", "3"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::pair<int, int> sizes[] = {{35, 22}, {17, 11}, {8, 5}, {4, 2}, {2, 1}, {1, 1}};
  for (std::size_t l = 0; l < std::size(sizes); ++l)
    for (const char* texture : {"normal_0", "orm_0", "anisotropy_0"}) {
      const Picture picture = level(texture + std::to_string(l) + ".png");
      EXPECT_EQ(std::make_pair(picture.width, picture.height), sizes[l]);
      EXPECT_EQ(picture.channels, 3);
      EXPECT_FALSE(picture.is_half);
    }
  // The finest level is the map itself, with the base's roughness and no maps beside it.
  const Picture source = read_picture(path("map.png")), finest = level("normal_00.png"), orm = level("orm_00.png");
  for (int y = 0; y < 22; ++y)
    for (int x = 0; x < 35; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(finest.at(x, y, c), source.at(x, y, c), 2.5f / 255.0f) << x << ", " << y;
  EXPECT_NEAR(orm.at(3, 4, 1), 0.2f, 0.5f / 255.0f);
  EXPECT_EQ(orm.at(3, 4, 0), 1.0f);
  EXPECT_EQ(orm.at(3, 4, 2), 1.0f);
  EXPECT_EQ(level("anisotropy_00.png").at(3, 4, 2), 0.0f);
  // The coarsest is rougher than the base, and its axis is a direction.
  EXPECT_GT(level("orm_05.png").at(0, 0, 1), 0.3f);
  const Picture axis = level("anisotropy_05.png");
  EXPECT_NEAR(std::hypot(2.0f * axis.at(0, 0, 0) - 1.0f, 2.0f * axis.at(0, 0, 1) - 1.0f), 1.0f, 0.02f);

  const auto report = nlohmann::json::parse(read_bytes(path("r.json")));
  EXPECT_EQ(report["levels"], 6);
  EXPECT_EQ(report["files"].size(), 18u);
  for (const std::string name : report["files"]) EXPECT_TRUE(std::filesystem::exists(name)) << name;
  for (const char* kernel : {"one_lobe_finest", "one_lobe_samples", "one_lobe_fit"})
    EXPECT_GT(report["launches"][kernel], 0) << kernel;
  // A level that the map lacks is not measured.
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
  // Half of all facets are those of roughness 0.2, half those of 0.8.
  EXPECT_GT(second.at(0, 0, 1), 0.4f);
  EXPECT_LT(second.at(0, 0, 1), 0.8f);
  // Gloss is the other way round; named channels are taken.
  ASSERT_EQ(run({"--gloss", path("orm.png") + ":R", "--format", "exr", "--no-measure"}).exit_code, 0);
  EXPECT_NEAR(level("orm_00.exr").at(0, 0, 1), 1.0f - 64.0f / 255.0f, 1e-3f);
  EXPECT_EQ(level("orm_00.exr").at(0, 0, 0), 1.0f);
}

// A KTX2 file has the bytes of the images, with alpha, and says what they are to a reader that is not ours.
TEST_F(ExportCommandTest, KtxParseReadsTheLevels) {
  const std::string script = MULTUM_SOURCE_DIR "/tests/cli/ktx2_reading.mjs";
  if (!program_works("node", "--version")) GTEST_SKIP() << "no node (Debian package nodejs)";
  if (run_program({"node", script}).exit_code != 0) GTEST_SKIP() << "no ktx-parse: tools/install_dependencies test";
  write("map.png", normal_image(35, 22));
  const std::vector<std::string> textures = {"normal", "orm", "anisotropy"};
  for (const bool is_half : {false, true}) {
    ASSERT_EQ(run({"--anisotropy", "--no-measure", "--format", is_half ? "exr" : "png"}).exit_code, 0);
    ASSERT_EQ(run({"--anisotropy", "--no-measure", "--format", is_half ? "ktx2-half" : "ktx2"}).exit_code, 0);
    std::vector<std::string> command = {"node", script};
    for (const std::string& texture : textures) command.push_back(path("out/" + texture + ".ktx2"));
    const ProgramResult result = run_program(command);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto files = nlohmann::json::parse(result.out);
    ASSERT_EQ(files.size(), textures.size());
    for (std::size_t t = 0; t < textures.size(); ++t) {
      const auto& file = files[t];
      EXPECT_EQ(file["vkFormat"], is_half ? 97 : 37);
      EXPECT_EQ(file["typeSize"], is_half ? 2 : 1);
      EXPECT_EQ(file["size"], nlohmann::json::parse("[35, 22, 0]"));
      EXPECT_EQ(file["counts"], nlohmann::json::parse("[0, 1]"));
      EXPECT_EQ(file["supercompression"], 0);
      EXPECT_EQ(file["keys"]["KTXorientation"], "rd");
      EXPECT_EQ(file["keys"]["KTXwriter"].get<std::string>().rfind("multum ", 0), 0u);
      ASSERT_EQ(file["descriptors"].size(), 1u);
      const auto& descriptor = file["descriptors"][0];
      EXPECT_EQ(descriptor["model"], 1);     // RGBSDA
      EXPECT_EQ(descriptor["transfer"], 1);  // linear
      EXPECT_EQ(descriptor["planes"][0], is_half ? 8 : 4);
      ASSERT_EQ(descriptor["samples"].size(), 4u);
      for (int c = 0; c < 4; ++c) {
        const auto& sample = descriptor["samples"][static_cast<std::size_t>(c)];
        EXPECT_EQ(sample[0], (is_half ? 16 : 8) * c);
        EXPECT_EQ(sample[1], is_half ? 15 : 7);  // less 1
        EXPECT_EQ(sample[2], (c == 3 ? 15 : c) | (is_half ? 0xc0 : 0));
      }
      ASSERT_EQ(file["levels"].size(), 6u);
      for (int l = 0; l < 6; ++l) {
        const Picture image = level(textures[t] + "_0" + std::to_string(l) + (is_half ? ".exr" : ".png"));
        const auto bytes = decode_base64(file["levels"][static_cast<std::size_t>(l)]["bytes"]);
        ASSERT_TRUE(bytes);
        ASSERT_EQ(bytes->size(), static_cast<std::size_t>(image.width * image.height) * (is_half ? 8 : 4));
        for (int i = 0; i < image.width * image.height; ++i)
          for (int c = 0; c < 4; ++c) {
            const std::size_t at = static_cast<std::size_t>(4 * i + c);
            const auto byte = [&](std::size_t b) { return static_cast<std::uint8_t>((*bytes)[b]); };
            const float found = is_half
                                    ? half_to_float(static_cast<std::uint16_t>(byte(2 * at) | byte(2 * at + 1) << 8))
                                    : static_cast<float>(byte(at)) / 255.0f;
            const float expected = c == 3 ? 1.0f : image.values[static_cast<std::size_t>(3 * i + c)];
            ASSERT_NEAR(found, expected, 1e-6f) << textures[t] << ", level " << l << ", texel " << i << ", " << c;
          }
      }
    }
  }
}

TEST_F(ExportCommandTest, IsTheSameForAnyMemoryAndThreads) {
  write("map.png", normal_image(150, 90));
  const auto files = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--anisotropy", "--no-measure"});
    EXPECT_EQ(run(more).exit_code, 0);
    more.insert(more.end(), {"--format", "ktx2-half"});
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
  expect_refused({"--report", path("no/r.json")}, kEnvironment, {"no"});
  expect_refusal(multum({"export", path("none.png"), "-o", path("out")}), kInput, {"none.png"});
  expect_refusal(multum({"export", path("map.png"), "-o", path("a.ktx2")}), kUsage, {"a.ktx2", "a folder"});
  expect_refusal(multum({"export", path("map.png"), "-o", path("map.png/out")}), kEnvironment, {"map.png"});
  expect_refusal(multum({"export", path("map.png")}), kUsage, {"--output"});
  // A folder whose images are the export's own source.
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
