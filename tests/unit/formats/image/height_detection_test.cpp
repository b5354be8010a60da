// SPDX-License-Identifier: Apache-2.0
// Tests heights as mapping programs write them: with missing texels, and with bytes that are spread over several
// channels. The expected slopes are those of the original heights.
#include "host/formats/image/normals/normal_map.h"

#include <cmath>
#include <functional>
#include <random>

#include "host/formats/image/normals/packed_heights.h"
#include "tests/unit/formats/image/image_test_files.h"
#include "tests/unit/foundation/base/text_parts.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;
using Height = std::function<double(int, int)>;

double hills(int x, int y) { return 420.0 + 300.0 * std::sin(0.05 * x) * std::cos(0.04 * y) + 2.0 * x; }

// Inside the map, the slopes differ by at most `tolerance` from the central differences of a surface.
void expect_slopes(
    const NormalMap& map, const Height& height, double tolerance,
    const std::function<bool(int, int)>& is_left_out = [](int, int) { return false; }) {
  for (int row = 1; row + 1 < map.height; ++row)
    for (int column = 1; column + 1 < map.width; ++column) {
      if (is_left_out(column, row)) continue;
      const auto i = static_cast<std::size_t>(row * map.width + column);
      const double z = static_cast<double>(map.z[i]);
      ASSERT_NEAR(-static_cast<double>(map.x[i]) / z, (height(column + 1, row) - height(column - 1, row)) / 2,
                  tolerance)
          << column << ", " << row;
      ASSERT_NEAR(-static_cast<double>(map.y[i]) / z, (height(column, row - 1) - height(column, row + 1)) / 2,
                  tolerance)
          << column << ", " << row;
    }
}

TestImage int16_image(int width, int height, const Height& metres) {
  TestImage image{.width = width, .height = height, .channels = 1, .type = TypeDesc::INT16};
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column)
      image.values.push_back(static_cast<float>(std::round(metres(column, row)) / 32767.0));
  return image;
}

// Stores a 24-bit number in three channels of 8 bits.
TestImage byte_channels(int width, int height, const Height& number) {
  TestImage image{.width = width, .height = height, .channels = 3};
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const auto bytes = static_cast<std::uint32_t>(std::llround(number(column, row)));
      for (const int shift : {16, 8, 0}) image.values.push_back(static_cast<float>(bytes >> shift & 255u) / 255.0f);
    }
  return image;
}

NormalMap read_image(const TestImage& image, const char* name, float scale, BumpFormat format = BumpFormat::kAuto) {
  const TemporaryFolder folder;
  write_test_image(folder / name, image);
  NormalMapSettings settings;
  settings.bump_format = format;
  settings.height_scale = scale;
  settings.wrap_s = settings.wrap_t = WrapMode::kClamp;
  return read_map(folder / name, settings);
}

std::string all_warnings_of(const NormalMap& map) {
  std::string text;
  for (const std::string& warning : map.report.warnings) text += warning + "\n";
  return text;
}

bool is_hole(int x, int y) { return (x - 30) * (x - 30) + (y - 40) * (y - 40) < 200; }
bool is_near_hole(int x, int y) {
  return is_hole(x, y) || is_hole(x - 1, y) || is_hole(x + 1, y) || is_hole(x, y - 1) || is_hole(x, y + 1);
}

// Holes become flat areas instead of cliffs of 32 km. The stated range is the range of the valid heights.
TEST(HeightDetection, Int16WithoutDataIsNoCliff) {
  const auto metres = [](int x, int y) { return is_hole(x, y) ? -32768.0 : std::round(hills(x, y)); };
  for (const BumpFormat format : {BumpFormat::kAuto, BumpFormat::kHeight}) {
    const NormalMap map = read_image(int16_image(120, 100, metres), "h.tif", 32767.0f / 30.0f, format);
    expect_slopes(
        map, [&](int x, int y) { return metres(x, y) / 30.0; }, 2e-4, is_near_hole);
    expect_says(map.report.encoding, {"no data (-32768)", "values 180 to 911 of 32767"});
    EXPECT_EQ(map.report.encoding.find("values -32768"), std::string::npos) << map.report.encoding;
    EXPECT_GT(map.report.unused_texels, 500);
    EXPECT_EQ(map.report.nonfinite_repaired + map.report.below_horizon_repaired, 0);
    EXPECT_EQ(map.z[static_cast<std::size_t>(40 * 120 + 30)], 1.0f);
    // Next to the hole, differences are one-sided, so they give the slope of the hill and not half of it.
    const auto beside = static_cast<std::size_t>(40 * 120 + 30 + 15);
    EXPECT_NEAR(-static_cast<double>(map.x[beside]) / static_cast<double>(map.z[beside]),
                (metres(46, 40) - metres(45, 40)) / 30.0, 2e-4);
  }
  const auto deep = [](int x, int y) { return x == 5 && y == 5 ? -32768.0 : -200.0 * x; };  // to -23,800
  EXPECT_EQ(read_image(int16_image(120, 100, deep), "h.tif", 32767.0f / 400.0f).report.unused_texels, 0);
}

TEST(HeightDetection, OtherValuesOfNoData) {
  for (const double hole : {-9999.0, -32767.0, -3.4028234663852886e38}) {
    TestImage image{.width = 120, .height = 100, .channels = 1, .type = TypeDesc::FLOAT};
    for (int row = 0; row < 100; ++row)
      for (int column = 0; column < 120; ++column)
        image.values.push_back(static_cast<float>(is_hole(column, row) ? hole : hills(column, row)));
    const NormalMap map = read_image(image, "h.tif", 1.0f / 30.0f);
    expect_slopes(
        map, [](int x, int y) { return hills(x, y) / 30.0; }, 2e-4, is_near_hole);
    EXPECT_GT(map.report.unused_texels, 500) << hole;
  }
}

TEST(HeightDetection, PackedBytesAreDecoded) {
  struct Case {
    const char* name;
    Height number;
    double unit;  // the height that the number 1 stands for
    BumpFormat format;
    double tolerance;
  };
  const Case cases[] = {{"packed in red and green", [](int x, int y) { return 256.0 * std::round(40.0 * hills(x, y)); },
                         1.0 / 40 / 256, BumpFormat::kPacked16, 0.002},
                        {"Terrarium", [](int x, int y) { return std::round((hills(x, y) + 32768.0) * 256.0); },
                         1.0 / 256, BumpFormat::kTerrarium, 0.001},
                        {"Terrarium", [](int x, int y) { return std::round(hills(x, y) + 32768.0) * 256.0; }, 1.0 / 256,
                         BumpFormat::kTerrarium, 0.03},
                        {"Mapbox", [](int x, int y) { return std::round((hills(x, y) + 10000.0) * 10.0); }, 1.0 / 10,
                         BumpFormat::kMapbox, 0.004}};
  for (const Case& test : cases) {
    SCOPED_TRACE(test.name);
    const TestImage image = byte_channels(160, 90, test.number);
    const float scale = test.format == BumpFormat::kPacked16 ? 65535.0f / 40.0f / 30.0f : 1.0f / 30.0f;
    for (const BumpFormat format : {BumpFormat::kAuto, BumpFormat::kHeight, test.format}) {
      const NormalMap map = read_image(image, "h.png", scale, format);
      expect_says(map.report.encoding, {"height field", test.name});
      expect_slopes(
          map, [&](int x, int y) { return hills(x, y) / 30.0; }, test.tolerance);
      EXPECT_EQ(all_warnings_of(map), "");
    }
  }
}

// Smooth and noisy normals and colours are not mistaken for numbers that are spread over channels.
TEST(HeightDetection, OtherPicturesAreNotPacked) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> noise(0.0f, 1.0f);
  TestImage smooth{.width = 96, .height = 64}, rough = smooth;
  for (int i = 0; i < 96 * 64; ++i)
    for (int c = 0; c < 3; ++c) {
      smooth.values.push_back(static_cast<float>(0.5 + 0.4 * std::sin(0.01 * i * (c + 1))));
      rough.values.push_back(noise(random));
    }
  for (const TestImage& image : {smooth, rough, normal_image(96, 64)}) {
    const TemporaryFolder folder;
    write_test_image(folder / "c.png", image);
    NormalMapSettings settings;
    settings.bump_format = BumpFormat::kHeight;
    expect_error(ErrorCode::kInput, {"c.png", "found colours", "one channel", "packed16"},
                 [&] { read_map(folder / "c.png", settings); });
  }
}

TEST(HeightDetection, HeightsMustBeGrey) {
  TestImage grey{.width = 64, .height = 48};
  for (int i = 0; i < 64 * 48; ++i)
    for (int c = 0; c < 3; ++c) grey.values.push_back(static_cast<float>(i % 64) / 255.0f);
  EXPECT_EQ(read_image(grey, "g.png", 60.0f, BumpFormat::kHeight).width, 64);
  EXPECT_EQ(read_image(grey, "g.jpg", 60.0f, BumpFormat::kHeight).width, 64);
  TestImage two{.width = 64, .height = 48, .channels = 2, .type = TypeDesc::FLOAT, .channel_names = {"R", "G"}};
  for (int i = 0; i < 64 * 48; ++i)
    for (int c = 0; c < 2; ++c) two.values.push_back(static_cast<float>(i % 64) / (c == 0 ? 64.0f : 20.0f));
  const TemporaryFolder folder;
  write_test_image(folder / "two.exr", two);
  NormalMapSettings settings;
  settings.bump_format = BumpFormat::kHeight;
  expect_error(ErrorCode::kInput, {"two.exr", "found colours"}, [&] { read_map(folder / "two.exr", settings); });
  settings.bump_format = BumpFormat::kTerrarium;
  expect_error(ErrorCode::kInput, {"two.exr", "expected 3 channels of 8 bits", "Terrarium"},
               [&] { read_map(folder / "two.exr", settings); });
}

}  // namespace
}  // namespace multum::testing
