// SPDX-License-Identifier: Apache-2.0
// Tests that roughness becomes lengths of normals, that channels become weights, and that values outside 0 to 1 are
// refused.
#include "host/formats/image/material_maps.h"

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;

// Channel c of texel i has the value 0.1 (i + 1) + 0.02 c.
TestImage four_channels(TypeDesc::BASETYPE type, int channels) {
  TestImage image{.width = 3, .height = 2, .channels = channels, .type = type};
  for (int i = 0; i < 6; ++i)
    for (int c = 0; c < channels; ++c)
      image.values.push_back(0.1f * static_cast<float>(i + 1) + 0.02f * static_cast<float>(c));
  if (channels == 4) image.alpha_channel = 3;
  if (channels == 2) image.alpha_channel = 1;
  return image;
}

PlaneStore flat(int width, int height) {
  PlaneStore store(width, height);
  const std::vector<float> x(static_cast<std::size_t>(width * height), 0.6f), y(x.size()), z(x.size(), 0.8f);
  store.write_rows(0, height, {x.data(), y.data(), z.data()});
  return store;
}

// Returns the roughness of texel 0 that is read from a channel of four_channels().
double roughness_read(const std::string& text) {
  PlaneStore normals = flat(3, 2);
  shorten_by_roughness(normals, parse_channel_file(text), {}, 1);
  const double c = static_cast<double>(normals.texel(0, 0)[0]) / static_cast<double>(0.6f);
  return std::pow(2.0 * (1.0 - c), 0.25);
}

TEST(RoughnessMap, MeanCosineIsThatOfBlinnPhongOfTheSamePeak) {
  EXPECT_EQ(mean_cosine_of_roughness(0.0), 1.0);
  EXPECT_EQ(mean_cosine_of_roughness(1.0), 0.5);
  for (const double roughness : {0.1, 0.3, 0.5, 0.8}) {
    const double alpha = roughness * roughness, s = 2.0 / (alpha * alpha) - 2.0;
    EXPECT_NEAR(mean_cosine_of_roughness(roughness), (s + 1.0) / (s + 2.0), 1e-14) << roughness;
  }
}

TEST(RoughnessMap, ChannelsAreChosenByLetterOrNameAndGreenIsTheUsual) {
  const TemporaryFolder folder;
  write_test_image(folder / "a.png", four_channels(TypeDesc::UINT16, 4));
  const std::string path = folder / "a.png";
  constexpr double kStep = 1.0 / 65535.0;
  EXPECT_NEAR(roughness_read(path), 0.12, 10 * kStep);  // the precision is 16 bits, and the fourth root of a length in
                                                        // single precision
  EXPECT_NEAR(roughness_read(path + ":R"), 0.10, 20 * kStep);
  EXPECT_NEAR(roughness_read(path + ":B"), 0.14, 10 * kStep);
  EXPECT_NEAR(roughness_read(path + ":A"), 0.16, 10 * kStep);
  TestImage one = four_channels(TypeDesc::FLOAT, 1);
  one.channel_names = {"material.rough"};
  write_test_image(folder / "b.exr", one);
  EXPECT_NEAR(roughness_read(folder / "b.exr"), 0.1, 1e-3);
  EXPECT_NEAR(roughness_read((folder / "b.exr") + ":material.rough"), 0.1, 1e-3);
  // A file whose name contains a colon is still a file.
  std::filesystem::copy_file(path, folder / "c:A");
  EXPECT_NEAR(roughness_read(folder / "c:A"), 0.12, 10 * kStep);
}

TEST(RoughnessMap, ZeroChangesNothingAndOneHalves) {
  const TemporaryFolder folder;
  TestImage image{.width = 2, .height = 1, .channels = 1, .type = TypeDesc::UINT8};
  image.values = {0.0f, 1.0f};
  write_test_image(folder / "a.png", image);
  PlaneStore normals = flat(2, 1);
  EXPECT_EQ(shorten_by_roughness(normals, {folder / "a.png", ""}, {}, 1).mean_cosine, 0.75);
  EXPECT_EQ(normals.texel(0, 0), (std::array<float, 3>{0.6f, 0.0f, 0.8f}));
  EXPECT_EQ(normals.texel(1, 0), (std::array<float, 3>{0.3f, 0.0f, 0.4f}));
}

// Reads a map of 16 x 16 texels with the values value(i, c).
RoughnessReport report_of(int channels, const std::function<float(int i, int c)>& value, bool is_gloss = false,
                          const std::string& channel = "", const std::string& name = "map.exr") {
  const TemporaryFolder folder;
  TestImage image{.width = 16, .height = 16, .channels = channels, .type = TypeDesc::FLOAT};
  for (int i = 0; i < 256; ++i)
    for (int c = 0; c < channels; ++c) image.values.push_back(value(i, c));
  write_test_image(folder / name, image);
  PlaneStore normals = flat(16, 16);
  return shorten_by_roughness(normals, {folder / name, channel, is_gloss}, {}, 2);
}

TEST(RoughnessMap, SaysWhatItHolds) {
  const auto steps = [](int i, int) { return i < 64 ? 1.0f : 0.2f + 0.25f * static_cast<float>(i % 2); };
  const RoughnessReport report = report_of(1, steps);
  EXPECT_FLOAT_EQ(static_cast<float>(report.least), 0.2f);
  EXPECT_EQ(report.most, 1.0);
  EXPECT_NEAR(report.mean, 0.25 + 0.75 * 0.325, 1e-6);
  EXPECT_EQ(report.share_zero, 0.0);
  EXPECT_EQ(report.share_one, 0.25);
  EXPECT_TRUE(report.warnings.empty());
  expect_says(report.to_text(), {"0.2 to 1", "mean 0.494", "0 % at 0", "25 % at 1"});
  const RoughnessReport gloss = report_of(
      1, [&](int i, int c) { return 1.0f - steps(i, c); }, true);
  EXPECT_NEAR(gloss.mean, report.mean, 1e-6);
  EXPECT_NEAR(gloss.mean_cosine, report.mean_cosine, 1e-6);
  EXPECT_EQ(gloss.share_one, 0.25);
}

// Imitates the files of shared/data. Specular maps are dark, and the channels of pictures are correlated. The channels
// of packed maps (occlusion, roughness, metalness) are not correlated, and grey files have three equal channels.
TEST(RoughnessMap, WhatSeemsToBeNoneIsWarnedOf) {
  const auto wave = [](int i, double by) { return static_cast<float>(0.5 + 0.3 * std::sin(by * i)); };
  const auto rough = [&](int i, int) { return wave(i, 0.7); };
  const auto packed = [&](int i, int c) { return c == 0 ? 1.0f : c == 1 ? wave(i, 0.7) : wave(i, 1.9); };
  const auto coloured = [&](int i, int c) { return wave(i, 0.7) * (1.0f - 0.1f * static_cast<float>(c)); };
  const auto dark = [](int i, int) { return i % 4 == 0 ? 0.6f : 0.05f; };
  EXPECT_TRUE(report_of(1, rough).warnings.empty());
  EXPECT_TRUE(report_of(3, rough).warnings.empty()) << "grey";
  EXPECT_TRUE(report_of(3, packed).warnings.empty());
  ASSERT_EQ(report_of(3, coloured).warnings.size(), 1u);
  expect_says(report_of(3, coloured).warnings[0], {"map.exr: ", "correlation of 1.00", "specular", "FILE:CHANNEL"});
  EXPECT_TRUE(report_of(3, coloured, false, "R").warnings.empty()) << "the channel was named";
  ASSERT_EQ(report_of(1, dark).warnings.size(), 1u);
  expect_says(report_of(1, dark).warnings[0], {"map.exr: ", "75 %", "0.1", "specular"});
  EXPECT_EQ(report_of(3, dark, false, "B").warnings.size(), 1u);
  EXPECT_TRUE(report_of(1, dark, true).warnings.empty()) << "dark gloss is rough";
  const auto black = [](int i, int) { return i % 4 == 0 ? 0.6f : 0.0f; };
  ASSERT_EQ(report_of(1, black, true).warnings.size(), 1u);
  expect_says(report_of(1, black, true).warnings[0], {"map.exr: ", "75 %", "no gloss", "specular"});
  // Channels that are not read may contain any number.
  const auto broken = [&](int i, int c) { return c == 1 ? rough(i, c) : c == 0 ? NAN : -5.0f; };
  EXPECT_TRUE(report_of(3, broken).warnings.empty());
}

TEST(RoughnessMap, ANameSaysWhatTheMapIs) {
  const std::pair<const char*, NamedMap> names[] = {{"bricks_gloss.png", NamedMap::kGloss},
                                                    {"a/BricksRoughness2K.png", NamedMap::kRoughness},
                                                    {"rough_wood_gloss_1k.png", NamedMap::kGloss},
                                                    {"floor_s.png", NamedMap::kSpecular},
                                                    {"floor_r.jpg", NamedMap::kRoughness},
                                                    {"r_floor.png", NamedMap::kUnknown},
                                                    {"pipe_specularMap.png", NamedMap::kSpecular},
                                                    {"pipeRough.png", NamedMap::kRoughness},
                                                    {"pipeS.png", NamedMap::kSpecular},
                                                    {"steel-metallicRoughness.png", NamedMap::kRoughness},
                                                    {"steel_metallicroughness.png", NamedMap::kRoughness},
                                                    {"steel_roughness_metallic.png", NamedMap::kRoughness},
                                                    {"steel_metallic.png", NamedMap::kMetalness},
                                                    {"metal_plate.png", NamedMap::kUnknown},
                                                    {"rough/plate.png", NamedMap::kUnknown},
                                                    {"special_glossary.png", NamedMap::kUnknown}};
  for (const auto& [name, map] : names) EXPECT_EQ(map_by_name(name), map) << name;
}

TEST(RoughnessMap, ANameThatSaysAnotherMapIsWarnedOf) {
  const auto rough = [](int i, int) { return static_cast<float>(0.5 + 0.3 * std::sin(0.7 * i)); };
  const auto warning = [&](bool is_gloss, const std::string& name, const std::string& channel = "") {
    const std::vector<std::string> found = report_of(1, rough, is_gloss, channel, name).warnings;
    EXPECT_LE(found.size(), 1u);
    return found.empty() ? "" : found[0];
  };
  EXPECT_EQ(warning(true, "a_gloss.exr"), "");
  EXPECT_EQ(warning(false, "a_roughness.exr"), "");
  expect_says(warning(false, "a_gloss.exr"),
              {"a_gloss.exr: ", "gloss map", "given as --roughness", "--gloss would invert"});
  expect_says(warning(true, "a_r.exr", "R"),
              {"a_r.exr: ", "roughness map", "given as --gloss", "--roughness would invert"});
  expect_says(warning(true, "a_s.exr"), {"a_s.exr: ", "specular map", "given as --gloss"});
  expect_says(warning(false, "a_metallic.exr"), {"metalness map", "given as --roughness"});
  EXPECT_EQ(warning(true, "a_s.exr", "R"), "") << "the channel was named";
  // For a polished surface, the file name decides if the numbers are not conclusive.
  const auto polished = [](int i, int) { return i % 2 == 0 ? 0.6f : 0.95f; };
  EXPECT_TRUE(report_of(1, polished, true, "", "a_gloss.exr").warnings.empty());
  EXPECT_EQ(report_of(1, polished, true).warnings.size(), 1u);
}

TEST(RoughnessMap, BandsScratchFilesAndThreadsCannotBeSeen) {
  const TemporaryFolder folder;
  TestImage image{.width = 37, .height = 90, .channels = 3, .type = TypeDesc::UINT8};
  for (int i = 0; i < 37 * 90 * 3; ++i) image.values.push_back(static_cast<float>(i % 251) / 250.0f);
  write_test_image(folder / "a.png", image);
  PlaneStore whole = flat(37, 90);
  const double mean = shorten_by_roughness(whole, {folder / "a.png", "B"}, {}, 1).mean_cosine;
  PlaneStore stored(37, 90, ::testing::TempDir());
  std::vector<float> x(37 * 90), y(x.size()), z(x.size());
  flat(37, 90).read_rows(0, 90, {x.data(), y.data(), z.data()});
  stored.write_rows(0, 90, {x.data(), y.data(), z.data()});
  EXPECT_EQ(shorten_by_roughness(stored, {folder / "a.png", "B"}, {.band_rows = 7}, 3).mean_cosine, mean);
  for (int row = 0; row < 90; ++row) EXPECT_EQ(stored.texel(row % 37, row), whole.texel(row % 37, row));
}

TEST(RoughnessMap, WhatCannotBeIsRefused) {
  const TemporaryFolder folder;
  write_test_image(folder / "a.png", four_channels(TypeDesc::UINT8, 3));
  const auto shorten = [&](const std::string& name, const std::string& channel, int width) {
    PlaneStore normals = flat(width, 2);
    shorten_by_roughness(normals, {folder / name, channel}, {}, 2);
  };
  expect_error(ErrorCode::kInput, {"a.png", "roughness", "3 x 2", "5 x 2"}, [&] { shorten("a.png", "", 5); });
  expect_error(ErrorCode::kInput, {"a.png", "no channel A", "R, G, B"}, [&] { shorten("a.png", "A", 3); });
  expect_error(ErrorCode::kInput, {"a.png", "no channel rough"}, [&] { shorten("a.png", "rough", 3); });
  for (const float bad :
       {-0.25f, 1.5f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    TestImage image = four_channels(TypeDesc::FLOAT, 3);
    image.values[3 * 4 + 1] = bad;  // green of texel (1, 1)
    write_test_image(folder / "b.exr", image);
    expect_error(ErrorCode::kInput, {"b.exr", "(1, 1)", "channel G", "0 to 1"}, [&] { shorten("b.exr", "", 3); });
    shorten("b.exr", "R", 3);  // channels that are not read do not matter
  }
}

// Notes about pages, orientation and similar properties are reported for every map, with the name of the map.
TEST(MaterialMaps, WhatIsNotHeededIsSaid) {
  const TemporaryFolder folder;
  const std::string path = folder / "two.tif";
  const OIIO::ImageSpec spec(3, 2, 3, TypeDesc::UINT8);
  const std::vector<float> values(18, 0.5f);
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(output->open(path, spec));
  ASSERT_TRUE(output->write_image(TypeDesc::FLOAT, values.data()));
  ASSERT_TRUE(output->open(path, spec, OIIO::ImageOutput::AppendSubimage));
  ASSERT_TRUE(output->write_image(TypeDesc::FLOAT, values.data()));
  output->close();
  const auto expect_said = [&](const std::vector<std::string>& warnings) {
    ASSERT_FALSE(warnings.empty());
    expect_says(warnings.front(), {"two.tif", "2 pages"});
  };
  PlaneStore normals = flat(3, 2);
  expect_said(shorten_by_roughness(normals, {path, "", false}, {}, 1).warnings);
  expect_said(shorten_by_roughness(normals, {path, "", true}, {}, 1).warnings);
  expect_said(read_weight_map(path, 3, 2, {}, 1).warnings);
  expect_said(read_lobe_material({{}, {path, ""}, {}}, 3, 2, {}, 1).warnings);
  expect_said(read_lobe_material({{}, {}, {path, ""}}, 3, 2, {}, 1).warnings);
}

TEST(WeightMaps, EveryChannelIsAWeight) {
  const TemporaryFolder folder;
  for (int channels = 1; channels <= 4; ++channels) {
    write_test_image(folder / "a.png", four_channels(TypeDesc::UINT16, channels));
    const WeightMap map = read_weight_map(folder / "a.png", 3, 2, {}, 2);
    ASSERT_EQ(map.count, channels);
    ASSERT_EQ(map.rgb_planes.size(), channels == 4 ? 2u : 1u);
    for (int k = 0; k < 3 * static_cast<int>(map.rgb_planes.size()); ++k) {
      const float found = map.rgb_planes[static_cast<std::size_t>(k) / 3].texel(2, 1)[static_cast<std::size_t>(k) % 3];
      EXPECT_NEAR(found, k < channels ? 0.6 + 0.02 * k : 0.0, 1e-4) << channels << " channels, weight " << k;
    }
  }
}

TEST(WeightMaps, WhatCannotBeIsRefused) {
  const TemporaryFolder folder;
  write_test_image(folder / "a.png", four_channels(TypeDesc::UINT8, 4));
  expect_error(ErrorCode::kInput, {"a.png", "weights", "3 x 2", "4 x 4"},
               [&] { read_weight_map(folder / "a.png", 4, 4, {}, 1); });
  TestImage five = four_channels(TypeDesc::FLOAT, 5);
  five.channel_names = {"a", "b", "c", "d", "e"};
  write_test_image(folder / "b.exr", five);
  expect_error(ErrorCode::kInput, {"b.exr", "5 channels", "1 to 4"},
               [&] { read_weight_map(folder / "b.exr", 3, 2, {}, 1); });
  TestImage huge = four_channels(TypeDesc::FLOAT, 3);
  huge.values[2] = 1e6f;
  write_test_image(folder / "c.exr", huge);
  expect_error(ErrorCode::kInput, {"c.exr", "(0, 0)", "1000000", "weights"},
               [&] { read_weight_map(folder / "c.exr", 3, 2, {}, 1); });
}

}  // namespace
}  // namespace multum::testing
