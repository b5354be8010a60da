// SPDX-License-Identifier: Apache-2.0
// Tests the meaning of a normal map's blue: z from -1 to 1, z from 0 to 1, or something else. In the last case, the map
// is refused, and the message names the option with which it can be read.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <string>

#include <glm/geometric.hpp>

#include "host/foundation/base/messages/option_words.h"
#include "tests/unit/formats/image/image_test_files.h"
#include "tests/unit/foundation/base/text_parts.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;

constexpr int kMapSide = 128;

/// Returns normals that tilt by up to `degrees`.
std::vector<glm::dvec3> tilted_normals(double degrees) {
  std::vector<glm::dvec3> normals = surface_normals(kMapSide, kMapSide);
  double steepest = 0.0;
  for (const glm::dvec3& n : normals) steepest = std::max(steepest, std::hypot(n.x, n.y) / n.z);
  const double scale = std::tan(degrees * std::numbers::pi / 180.0) / steepest;
  for (glm::dvec3& n : normals) n = glm::normalize(glm::dvec3(scale * n.x, scale * n.y, n.z));
  return normals;
}

/// Makes an image with x and y as 0..1. `blue` gives the value of blue for each normal and position.
TestImage image_of(const std::vector<glm::dvec3>& normals,
                   const std::function<double(const glm::dvec3&, std::size_t)>& blue) {
  TestImage image{.width = kMapSide, .height = kMapSide};
  for (std::size_t i = 0; i < normals.size(); ++i)
    for (const double value : {0.5 + 0.5 * normals[i].x, 0.5 + 0.5 * normals[i].y, blue(normals[i], i)})
      image.values.push_back(static_cast<float>(value));
  return image;
}

double positive_z(const glm::dvec3& n, std::size_t) { return n.z; }

/// Makes waves from `low` to 1 that are independent of the normals.
std::function<double(const glm::dvec3&, std::size_t)> occlusion(double low, double period = 23.0) {
  return [=](const glm::dvec3&, std::size_t i) {
    const double x = static_cast<double>(i % kMapSide), y = static_cast<double>(i / kMapSide);
    return low + (1.0 - low) * (0.5 + 0.25 * std::sin(x / period * 6.283 + 1.0) + 0.25 * std::sin(y / 17.0 * 6.283));
  };
}

double degrees_off(const NormalMap& map, const std::vector<glm::dvec3>& normals) {
  return 2.0 * std::asin(0.5 * largest_difference(map, normals)) * 180.0 / std::numbers::pi;
}

/// Returns the message of Error(kInput), or "" if the map is read.
std::string refusal(const std::string& path, const NormalMapSettings& settings = {}) {
  try {
    read_map(path, settings);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    return error.what();
  }
  return "";
}

std::string all_warnings(const NormalMap& map) {
  std::string text;
  for (const std::string& warning : map.report.warnings) text += warning + "\n";
  return text;
}

class UseOfBlue : public ::testing::Test {
 protected:
  ~UseOfBlue() override { set_option_words(std::nullopt); }
  const TemporaryFolder folder_;
};

TEST_F(UseOfBlue, ZFromZeroToOneIsFound) {
  for (const double degrees : {16.0, 20.0, 36.0, 60.0, 80.0}) {
    const std::vector<glm::dvec3> normals = tilted_normals(degrees);
    for (const auto& [name, type] : {std::pair{"a.png", TypeDesc::UINT8}, {"a.png", TypeDesc::UINT16}}) {
      TestImage image = image_of(normals, positive_z);
      image.type = type;
      write_test_image(folder_ / name, image);
      SCOPED_TRACE(::testing::Message() << degrees << " degrees, " << name);
      const NormalMap map = read_map(folder_ / name);
      EXPECT_TRUE(contains(map.report.encoding, "z from 0 to 1")) << map.report.encoding_reason;
      EXPECT_TRUE(contains(map.report.encoding_reason, "2 * blue - 1")) << map.report.encoding_reason;
      EXPECT_LT(degrees_off(map, normals), 0.7);
    }
  }
}

TEST_F(UseOfBlue, OrdinaryNormalsKeepTheirZ) {
  for (const double degrees : {2.0, 10.0, 30.0, 70.0}) {
    const std::vector<glm::dvec3> normals = tilted_normals(degrees);
    TestImage image = image_of(normals, [](const glm::dvec3& n, std::size_t) { return 0.5 + 0.5 * n.z; });
    write_test_image(folder_ / "a.png", image);
    const NormalMap map = read_map(folder_ / "a.png");
    EXPECT_FALSE(contains(map.report.encoding, "z from")) << degrees << map.report.encoding_reason;
    EXPECT_LT(degrees_off(map, normals), 0.7) << degrees;
    EXPECT_FALSE(contains(all_warnings(map), "blue")) << all_warnings(map);
  }
}

TEST_F(UseOfBlue, TheSettingGoesBeforeWhatIsFound) {
  const std::vector<glm::dvec3> normals = tilted_normals(36.0);
  write_test_image(folder_ / "a.png", image_of(normals, positive_z));
  EXPECT_GT(degrees_off(read_map(folder_ / "a.png", {.z_range = ZRange::kSigned}), normals), 5.0);
  TestImage image = image_of(tilted_normals(5.0), positive_z);  // this map is too flat to decide
  image.type = TypeDesc::UINT8;
  write_test_image(folder_ / "flat.png", image);
  const NormalMap map = read_map(folder_ / "flat.png", {.z_range = ZRange::kPositive});
  EXPECT_TRUE(contains(map.report.encoding, "z from 0 to 1")) << map.report.encoding;
  EXPECT_LT(degrees_off(map, tilted_normals(5.0)), 0.7);
}

TEST_F(UseOfBlue, SomethingElseIsRefusedAndReadAsTwoChannels) {
  for (const double low : {0.1, 0.3, 0.55, 0.8})
    for (const double degrees : {20.0, 40.0}) {
      SCOPED_TRACE(::testing::Message() << low << ", " << degrees << " degrees");
      const std::vector<glm::dvec3> normals = tilted_normals(degrees);
      write_test_image(folder_ / "a.png", image_of(normals, occlusion(low)));
      const std::string message = refusal(folder_ / "a.png");
      EXPECT_TRUE(contains(message, "a.png")) << message;
      EXPECT_TRUE(contains(message, "--two-channel")) << message;
      EXPECT_LT(degrees_off(read_map(folder_ / "a.png", {.two_channel = true}), normals), 0.7);
      if (low < 0.8) continue;  // lower values give vectors below the horizon, or vectors that do not look like normals
      EXPECT_EQ(refusal(folder_ / "a.png", {.bump_format = BumpFormat::kNormal}), "");
      const NormalMapSettings strict = {.bump_format = BumpFormat::kNormal, .refuse_doubts = true};
      EXPECT_TRUE(contains(refusal(folder_ / "a.png", strict), "--two-channel"));
    }
}

TEST_F(UseOfBlue, WhoSaysThatItIsZIsObeyed) {
  write_test_image(folder_ / "a.png", image_of(tilted_normals(20.0), occlusion(0.8)));
  EXPECT_EQ(refusal(folder_ / "a.png", {.z_range = ZRange::kSigned}), "");
  const NormalMap map = read_map(folder_ / "a.png", {.bump_format = BumpFormat::kNormal});
  EXPECT_TRUE(contains(all_warnings(map), "blue does not depend")) << all_warnings(map);
}

// Averaged normals are short where the original normals differ, and lossy compression changes lengths. In both cases,
// blue is still z.
TEST_F(UseOfBlue, ShortAndLossyNormalsAreNotRefused) {
  const std::vector<glm::dvec3> fine = tilted_normals(65.0);
  std::vector<glm::dvec3> averaged(fine.size());
  for (int y = 0; y < kMapSide; ++y)
    for (int x = 0; x < kMapSide; ++x)
      for (int k = 0; k < 49; ++k)
        averaged[static_cast<std::size_t>(y * kMapSide + x)] +=
            fine[static_cast<std::size_t>((y + k / 7) % kMapSide * kMapSide + (x + k % 7) % kMapSide)] / 49.0;
  for (const char* name : {"a.png", "a.jpg", "a.webp"}) {
    const auto z = [](const glm::dvec3& n, std::size_t) { return 0.5 + 0.5 * n.z; };
    write_test_image(folder_ / name, image_of(averaged, z));
    EXPECT_EQ(refusal(folder_ / name), "") << name;
    EXPECT_FALSE(contains(all_warnings(read_map(folder_ / name)), "blue")) << name;
  }
}

// Advice names only options of the running command. Otherwise it is left out.
TEST_F(UseOfBlue, AdviceIsOfTheCommand) {
  write_test_image(folder_ / "a.png", image_of(tilted_normals(20.0), occlusion(0.8)));
  add_key_words({"two_channel", "z_range"});
  const std::string of_file = refusal(folder_ / "a.png");
  EXPECT_TRUE(contains(of_file, "two_channel = true")) << of_file;
  EXPECT_TRUE(contains(of_file, "z_range = \"signed\"")) << of_file;
  EXPECT_FALSE(contains(of_file, "--")) << of_file;
  set_option_words(std::set<std::string>{"output"});
  const std::string bare = refusal(folder_ / "a.png");
  EXPECT_TRUE(contains(bare, "expected the z of unit vectors")) << bare;
  EXPECT_FALSE(contains(bare, "--")) << bare;
}

// The warnings that a baked file stores about its source do not depend on the command.
TEST_F(UseOfBlue, WithoutAdviceAWarningIsTheSameForAllCommands) {
  write_test_image(folder_ / "a.png", image_of(tilted_normals(20.0), occlusion(0.8)));
  const auto warnings = [&] {
    return all_warnings(read_map(folder_ / "a.png", {.bump_format = BumpFormat::kNormal, .green = GreenAxis::kDown}));
  };
  const std::string of_options = warnings();
  add_key_words({"two_channel", "z_range", "green"});
  const std::string of_keys = warnings();
  EXPECT_TRUE(contains(with_advice(of_keys), "green = \"up\"")) << of_keys;
  EXPECT_NE(with_advice(of_options), with_advice(of_keys));
  EXPECT_EQ(without_advice(of_options), without_advice(of_keys));
  EXPECT_TRUE(contains(without_advice(of_keys), "blue does not depend")) << of_keys;
}

// Painters and bakers leave floats outside of charts at 0 or NaN.
TEST_F(UseOfBlue, WhatWasNeverWrittenIsFlatAndNoEvidence) {
  const std::vector<glm::dvec3> normals = tilted_normals(20.0);
  for (const float empty : {0.0f, kNan})
    for (const auto& [type, is_signed] :
         {std::pair{TypeDesc::FLOAT, true}, {TypeDesc::HALF, true}, {TypeDesc::FLOAT, false}}) {
      TestImage image{.width = kMapSide, .height = kMapSide, .type = type};
      for (std::size_t i = 0; i < normals.size(); ++i)
        for (const double value : {normals[i].x, normals[i].y, normals[i].z})
          image.values.push_back(i < normals.size() / 4 ? empty
                                                        : static_cast<float>(is_signed ? value : 0.5 + 0.5 * value));
      write_test_image(folder_ / "a.exr", image);
      SCOPED_TRACE(::testing::Message() << "empty " << empty << ", signed " << is_signed);
      const NormalMap map = read_map(folder_ / "a.exr");
      EXPECT_EQ(map.report.unused_texels, kMapSide * kMapSide / 4);
      EXPECT_EQ(map.report.nonfinite_repaired + map.report.zero_length_repaired, 0);
      EXPECT_TRUE(contains(map.report.encoding_reason, "length within 10 % of 1 in 100.0 %"))
          << map.report.encoding_reason;
      EXPECT_TRUE(contains(all_warnings(map), "count as unused")) << all_warnings(map);
      EXPECT_EQ(map.x[5], 0.0f);
      EXPECT_EQ(map.z[5], 1.0f);
      EXPECT_NEAR(map.x.back(), static_cast<float>(normals.back().x), 1e-3);
    }
}

// A few empty texels are faults of a renderer. They are repaired from their neighbours and counted.
TEST_F(UseOfBlue, SingleEmptyTexelsAreRepaired) {
  for (const float empty : {0.0f, kNan}) {
    TestImage image = normal_image(kMapSide, kMapSide, true);
    image.type = TypeDesc::FLOAT;
    for (int c = 0; c < 3; ++c) image.at(7, 9, c) = empty;
    write_test_image(folder_ / "a.exr", image);
    const NormalMap map = read_map(folder_ / "a.exr");
    EXPECT_EQ(map.report.unused_texels, 0);
    EXPECT_EQ(map.report.nonfinite_repaired + map.report.zero_length_repaired, 1);
  }
}

TEST_F(UseOfBlue, AFlatMapHasNothingToGain) {
  TestImage flat{.width = 32, .height = 32};
  for (int i = 0; i < 32 * 32; ++i) {
    const float step = static_cast<float>(i % 2) / 255.0f;  // 127 or 128
    for (const float value : {127.0f / 255.0f + step, 127.0f / 255.0f, 1.0f}) flat.values.push_back(value);
  }
  write_test_image(folder_ / "a.png", flat);
  EXPECT_TRUE(contains(all_warnings(read_map(folder_ / "a.png")), "bring no benefit"));
  write_test_image(folder_ / "b.png", normal_image(32, 32));
  EXPECT_FALSE(contains(all_warnings(read_map(folder_ / "b.png")), "bring no benefit"));
}

}  // namespace
}  // namespace multum::testing
