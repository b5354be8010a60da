// SPDX-License-Identifier: Apache-2.0
// Tests the messages and the choice of --wrap auto for maps that tile and maps that do not tile, separately for each
// direction.
#include <cmath>
#include <numbers>
#include <random>

#include "host/formats/image/normals/normal_map.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;

std::string warnings_of(const NormalMap& map) {
  std::string text;
  for (const std::string& warning : map.report.warnings) text += warning + "\n";
  return text;
}

NormalMapSettings settings_with(WrapOrigin origin, WrapMode mode = WrapMode::kPeriodic) {
  NormalMapSettings settings;
  settings.bump_format = BumpFormat::kHeight;
  settings.height_scale = 20.0f;
  settings.wrap_s = settings.wrap_t = mode;
  settings.wrap_s_origin = settings.wrap_t_origin = origin;
  return settings;
}

// Makes waves. They continue across a border that tiles, and are cut mid-wave at a border that does not tile.
TestImage waves(int width, int height, bool tiles_s, bool tiles_t) {
  TestImage image{.width = width, .height = height, .channels = 1, .type = TypeDesc::UINT16};
  const double u_waves = tiles_s ? 3.0 : 2.5, v_waves = tiles_t ? 2.0 : 2.6;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const double u = 2.0 * std::numbers::pi * u_waves * column / width;
      const double v = 2.0 * std::numbers::pi * v_waves * row / height;
      image.values.push_back(
          static_cast<float>(0.5 + 0.15 * std::sin(u + 1.2) + 0.15 * std::sin(v) + 0.1 * std::sin(u) * std::cos(v)));
    }
  return image;
}

TEST(Seam, EachDirectionIsToldByItself) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{64, 48}, {37, 101}, {512, 700}})
    for (const bool tiles_s : {false, true})
      for (const bool tiles_t : {false, true}) {
        SCOPED_TRACE(::testing::Message() << width << " x " << height << ", tiles " << tiles_s << tiles_t);
        write_test_image(folder / "a.png", waves(width, height, tiles_s, tiles_t));
        const std::string by_default = warnings_of(read_map(folder / "a.png", settings_with(WrapOrigin::kDefault)));
        EXPECT_EQ(by_default.find("along s (x)") != std::string::npos, !tiles_s) << by_default;
        EXPECT_EQ(by_default.find("along t (y)") != std::string::npos, !tiles_t) << by_default;
        const char* option = tiles_s ? "--twrap auto" : tiles_t ? "--swrap auto" : "--wrap auto";
        EXPECT_EQ(by_default.find(option) != std::string::npos, !tiles_s || !tiles_t) << "one warning: " << by_default;
        EXPECT_EQ(warnings_of(read_map(folder / "a.png", settings_with(WrapOrigin::kSaid))), "");
        EXPECT_EQ(warnings_of(read_map(folder / "a.png", settings_with(WrapOrigin::kDefault, WrapMode::kClamp))), "");

        const NormalMap found = read_map(folder / "a.png", settings_with(WrapOrigin::kFound));
        EXPECT_EQ(warnings_of(found), "");
        EXPECT_EQ(found.report.wrap_s, tiles_s ? WrapMode::kPeriodic : WrapMode::kClamp);
        EXPECT_EQ(found.report.wrap_t, tiles_t ? WrapMode::kPeriodic : WrapMode::kClamp);
        expect_says(found.report.encoding_reason, {tiles_s ? "periodic along s" : "clamp along s", "rms"});
        // Heights are differentiated only across borders that tile.
        NormalMapSettings said = settings_with(WrapOrigin::kSaid);
        said.wrap_s = found.report.wrap_s;
        said.wrap_t = found.report.wrap_t;
        const NormalMap same = read_map(folder / "a.png", said);
        EXPECT_EQ(found.x, same.x);
        EXPECT_EQ(found.y, same.y);
      }
}

TEST(Seam, NormalMapsAreMeasuredToo) {
  const TemporaryFolder folder;
  TestImage whole = normal_image(128, 96);
  write_test_image(folder / "whole.png", whole);
  EXPECT_EQ(warnings_of(read_map(folder / "whole.png")), "");
  TestImage cut{.width = 77, .height = 96};  // the left part of the map
  for (int row = 0; row < 96; ++row)
    for (int column = 0; column < 77; ++column)
      for (int c = 0; c < 3; ++c) cut.values.push_back(whole.at(column, row, c));
  write_test_image(folder / "cut.png", cut);
  const std::string said = warnings_of(read_map(folder / "cut.png"));
  expect_says(said, {"s (x)", "--swrap clamp", "--swrap auto"});
  EXPECT_EQ(said.find("--twrap"), std::string::npos) << said;
}

// Independent texels match at any border. If there are lines along the border, such as between tiles, the map also has
// such steps inside. One row or a few texels do not show whether a map tiles.
TEST(Seam, WhatOnlyLooksLikeOneIsNone) {
  const TemporaryFolder folder;
  std::mt19937 generator(7);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  for (const auto& [width, height] : {std::pair{64, 64}, {16, 16}, {200, 31}, {64, 1}, {1, 64}, {7, 7}, {5, 300}}) {
    TestImage noise{.width = width, .height = height, .channels = 1, .type = TypeDesc::UINT16};
    for (int i = 0; i < width * height; ++i) noise.values.push_back(uniform(generator));
    write_test_image(folder / "a.png", noise);
    const std::string said = warnings_of(read_map(folder / "a.png", settings_with(WrapOrigin::kDefault)));
    EXPECT_EQ(said.find("wrap"), std::string::npos) << width << " x " << height << ": " << said;
  }
  TestImage bricks{.width = 64, .height = 64, .channels = 1, .type = TypeDesc::UINT16};
  for (int i = 0; i < 64 * 64; ++i) {
    const bool is_joint = i % 16 < 2 || i / 64 % 16 < 2;  // at the left and the top of each brick, and hence of the map
    bricks.values.push_back(is_joint ? 0.2f : 0.8f + 0.1f * uniform(generator));
  }
  write_test_image(folder / "a.png", bricks);
  const std::string said = warnings_of(read_map(folder / "a.png", settings_with(WrapOrigin::kDefault)));
  EXPECT_EQ(said.find("wrap"), std::string::npos) << said;
}

}  // namespace
}  // namespace multum::testing
