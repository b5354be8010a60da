// SPDX-License-Identifier: Apache-2.0
// Compares slopes of height fields with surfaces of known slopes: a plane, a paraboloid (central differences are exact)
// and a sphere cap, with every wrap mode at the border.
#include "host/formats/image/normals/height_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;

TestImage height_image(int width, int height, const std::function<double(int, int)>& value) {
  TestImage image{.width = width, .height = height, .channels = 1, .type = TypeDesc::FLOAT, .channel_names = {"Y"}};
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) image.values.push_back(static_cast<float>(value(column, row)));
  return image;
}

// Returns (dh/dx, dh/dy), +Y up.
std::pair<double, double> slopes(const NormalMap& map, int column, int row) {
  const auto i = static_cast<std::size_t>(row * map.width + column);
  const double z = static_cast<double>(map.z[i]);
  return {-static_cast<double>(map.x[i]) / z, -static_cast<double>(map.y[i]) / z};
}

NormalMap read_heights(const TestImage& image, const NormalMapSettings& settings = {}) {
  const TemporaryFolder folder;
  write_test_image(folder / "h.exr", image);
  return read_map(folder / "h.exr", settings);
}

TEST(HeightField, PlaneAndScale) {
  for (const float scale : {1.0f, 4.0f, -0.5f}) {
    NormalMapSettings settings;
    settings.height_scale = scale;
    settings.wrap_s = settings.wrap_t = WrapMode::kClamp;
    // The plane rises to the right by 0.25 and downwards by 0.125 per texel: dh/dy is negative.
    const NormalMap map =
        read_heights(height_image(20, 12, [](int x, int y) { return 0.25 * x + 0.125 * y; }), settings);
    const auto [sx, sy] = slopes(map, 7, 5);
    EXPECT_NEAR(sx, 0.25 * static_cast<double>(scale), 1e-6);
    EXPECT_NEAR(sy, -0.125 * static_cast<double>(scale), 1e-6);
    EXPECT_NE(map.report.encoding.find("height field, scale"), std::string::npos) << map.report.encoding;
  }
}

TEST(HeightField, ParaboloidIsExact) {
  const NormalMap map = read_heights(
      height_image(33, 31, [](int x, int y) { return 0.02 * (x - 16) * (x - 16) - 0.01 * (y - 15) * (y - 15); }));
  for (int row = 1; row < 30; ++row) {
    for (int column = 1; column < 32; ++column) {
      const auto [sx, sy] = slopes(map, column, row);
      ASSERT_NEAR(sx, 0.04 * (column - 16), 1e-5);
      ASSERT_NEAR(sy, 0.02 * (row - 15), 1e-5);  // upwards is opposite to the order of rows
    }
  }
}

// The error is at most a sixth of the third derivative of the cap, which is 0.004 where the slope is below 1.
TEST(HeightField, SphereCap) {
  const double radius = 40.0;
  const NormalMap map = read_heights(height_image(50, 50, [=](int x, int y) {
    return std::sqrt(radius * radius - (x - 24.5) * (x - 24.5) - (y - 24.5) * (y - 24.5));
  }));
  for (int row = 8; row < 42; ++row) {
    for (int column = 8; column < 42; ++column) {
      const auto i = static_cast<std::size_t>(row * 50 + column);
      ASSERT_NEAR(map.x[i], (column - 24.5) / radius, 0.004);
      ASSERT_NEAR(map.y[i], -(row - 24.5) / radius, 0.004);
    }
  }
}

TEST(HeightField, WrapModesAtTheBorder) {
  const TestImage image = height_image(4, 1, [](int x, int) { return 1.0 + x * x; });  // 1 2 5 10
  const std::pair<WrapMode, std::pair<double, double>> cases[] = {
      {WrapMode::kPeriodic, {(2.0 - 10.0) / 2, (1.0 - 5.0) / 2}},
      {WrapMode::kClamp, {2.0 - 1.0, 10.0 - 5.0}},
      {WrapMode::kMirror, {2.0 - 1.0, 10.0 - 5.0}},
      {WrapMode::kBlack, {(2.0 - 0.0) / 2, (0.0 - 5.0) / 2}}};
  for (const auto& [mode, expected] : cases) {
    NormalMapSettings settings;
    settings.wrap_s = mode;
    settings.wrap_t = WrapMode::kClamp;
    const NormalMap map = read_heights(image, settings);
    EXPECT_NEAR(slopes(map, 0, 0).first, expected.first, 1e-5) << wrap_mode_name(mode);
    EXPECT_NEAR(slopes(map, 3, 0).first, expected.second, 1e-5) << wrap_mode_name(mode);
    EXPECT_NEAR(slopes(map, 0, 0).second, 0.0, 1e-6) << wrap_mode_name(mode);
  }
  // Tests the same along t (in a column), where the upward direction is opposite to the order of rows.
  const TestImage column = height_image(1, 4, [](int, int y) { return 1.0 + y * y; });
  NormalMapSettings settings;
  settings.wrap_s = WrapMode::kClamp;
  settings.wrap_t = WrapMode::kBlack;
  EXPECT_NEAR(slopes(read_heights(column, settings), 0, 0).second, (0.0 - 2.0) / 2, 1e-5);
}

// A slope of 14.7 degrees stays the same at the border, on all four sides and in the corners.
TEST(HeightField, APlaneEndsWithItsOwnSlope) {
  const TestImage image = height_image(20, 12, [](int x, int y) { return 0.21 * x - 0.157 * y; });
  for (const WrapMode mode : {WrapMode::kClamp, WrapMode::kMirror}) {
    NormalMapSettings settings;
    settings.wrap_s = settings.wrap_t = mode;
    const NormalMap map = read_heights(image, settings);
    for (int row = 0; row < 12; ++row)
      for (int column = 0; column < 20; ++column) {
        const auto [sx, sy] = slopes(map, column, row);
        ASSERT_NEAR(sx, 0.21, 1e-5) << wrap_mode_name(mode) << " " << column << ", " << row;
        ASSERT_NEAR(sy, 0.157, 1e-5) << wrap_mode_name(mode) << " " << column << ", " << row;
      }
  }
}

TEST(HeightField, IntegersAreZeroToOneAndGreyColoursCount) {
  const TemporaryFolder folder;
  for (const TypeDesc::BASETYPE type : {TypeDesc::UINT8, TypeDesc::UINT16}) {
    TestImage image{.width = 8, .height = 8, .type = type};
    for (int i = 0; i < 64; ++i)
      for (int c = 0; c < 3; ++c) image.values.push_back(static_cast<float>(i % 8) / 255.0f * 10.0f);
    write_test_image(folder / "h.png", image);
    NormalMapSettings settings;
    settings.height_scale = 25.5f;
    const NormalMap map = read_map(folder / "h.png", settings);
    EXPECT_NEAR(slopes(map, 3, 3).first, 1.0, 0.01);
  }
}

TEST(HeightField, NonfiniteHeights) {
  TestImage image = height_image(16, 16, [](int x, int) { return 0.5 * x; });
  image.at(7, 7, 0) = std::numeric_limits<float>::quiet_NaN();
  NormalMapSettings settings;
  settings.wrap_s = WrapMode::kClamp;
  const NormalMap map = read_heights(image, settings);
  EXPECT_EQ(map.report.nonfinite_repaired, 1);
  EXPECT_NEAR(slopes(map, 8, 7).first, 0.5, 1e-5);  // the neighbours' mean is on the plane
  settings.fix_nan = FixNan::kBlack;
  EXPECT_NEAR(slopes(read_heights(image, settings), 8, 7).first, 4.5 / 2, 1e-5);
  settings.check_nan = true;
  expect_error(ErrorCode::kInput, {"column 7, row 7"}, [&] { read_heights(image, settings); });
}

TEST(HeightField, CliffsAreLiftedAndCounted) {
  NormalMapSettings settings;
  settings.height_scale = 1e6f;
  settings.bump_format = BumpFormat::kHeight;
  const TestImage image = height_image(16, 16, [](int x, int) { return x < 8 ? 0.0 : 1.0; });
  expect_error(ErrorCode::kInput, {"64", "horizon"}, [&] { read_heights(image, settings); });
}

TEST(HeightField, OneOrTwoGreyValuesAreRefusedUnlessAskedFor) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3}) {
    for (const int values : {1, 2}) {
      for (const char* file : {"h.png", "h.jpg"}) {
        TestImage image{.width = 32, .height = 32, .channels = channels};
        for (int i = 0; i < 32 * 32; ++i)  // JPEG blocks are 8 wide
          for (int c = 0; c < channels; ++c)
            image.values.push_back(values == 2 && i / 8 % 2 == 0 ? 230.0f / 255.0f : 51.0f / 255.0f);
        write_test_image(folder / file, image);
        SCOPED_TRACE(std::string(file) + ", " + std::to_string(channels) + " channels");
        expect_error(ErrorCode::kInput, {file, "height field", values == 1 ? "0.2," : "mask", "--bumpformat height"},
                     [&] { read_map(folder / file); });
        NormalMapSettings settings;
        settings.bump_format = BumpFormat::kHeight;
        EXPECT_EQ(read_map(folder / file, settings).width, 32);
      }
    }
  }
  expect_error(ErrorCode::kInput, {"finite"}, [] {
    read_heights(height_image(4, 4, [](int, int) { return std::numeric_limits<double>::quiet_NaN(); }));
  });
}

TEST(HeightField, DoubtsAreWarnedOf) {
  const auto warnings = [](double slope, BumpFormat format) {
    NormalMapSettings settings;
    settings.bump_format = format;
    settings.wrap_s = WrapMode::kClamp;
    const TestImage image = height_image(64, 8, [=](int x, int) { return slope * x; });
    const std::vector<std::string> found = read_heights(image, settings).report.warnings;
    EXPECT_LE(found.size(), 1u);
    return found.empty() ? std::string() : found[0];
  };
  EXPECT_EQ(warnings(1.0, BumpFormat::kHeight), "");
  const std::string taken = warnings(1.0, BumpFormat::kAuto);
  testing::expect_says(taken, {"grey", "height field", "a height scale of 1"});
  EXPECT_EQ(taken.find("slope"), std::string::npos) << taken;
  for (const BumpFormat format : {BumpFormat::kAuto, BumpFormat::kHeight}) {
    const std::string flat = warnings(0.01, format), steep = warnings(10.0, format);
    testing::expect_says(flat, {"flat", "0.05 to 5", "a height scale of 1"});
    testing::expect_says(
        steep, {"no height scale is given", "84.3 degrees", "steep", "0.05 to 5", "--height-scale 0.05 would"});
  }
}

// The warning about a steep scale depends on where the scale comes from. If a map is refused because its slopes are too
// steep, the message also names a scale.
TEST(HeightField, ASteepScaleIsDoubtedWhoeverGaveIt) {
  NormalMapSettings settings;
  settings.bump_format = BumpFormat::kHeight;
  settings.wrap_s = WrapMode::kClamp;
  settings.height_scale = 100.0f;
  const TestImage image = height_image(64, 8, [](int x, int) { return 0.1 * x; });
  const std::vector<std::string> found = read_heights(image, settings).report.warnings;
  ASSERT_EQ(found.size(), 1u);
  testing::expect_says(found[0], {"steep", "a height scale of 100 may be wrong", "--height-scale 5 would"});
  EXPECT_EQ(found[0].find("no height scale"), std::string::npos) << found[0];
  settings.height_scale = 1.0f;
  expect_error(ErrorCode::kInput, {"horizon", "; --height-scale 1.4e-05", " would make it 0.5"},
               [&] { read_heights(height_image(64, 8, [](int x, int) { return 500.0 * x * x; }), settings); });
}

// The scale that the warning suggests causes no warning.
TEST(HeightField, TheSuggestedScaleIsOneToTake) {
  for (const double slope : {1e-5, 0.01, 30.0, 4e6}) {
    NormalMapSettings settings;
    settings.bump_format = BumpFormat::kHeight;
    settings.repair_share_max = 1.0f;
    settings.wrap_s = WrapMode::kClamp;
    const TestImage image = height_image(64, 8, [=](int x, int) { return slope * x; });
    const std::vector<std::string> found = read_heights(image, settings).report.warnings;
    ASSERT_EQ(found.size(), 1u) << slope;
    const std::string mark = "; --height-scale ";
    const std::size_t at = found[0].find(mark);
    ASSERT_NE(at, std::string::npos) << found[0];
    settings.height_scale = std::stof(found[0].substr(at + mark.size()));
    EXPECT_TRUE(read_heights(image, settings).report.warnings.empty()) << settings.height_scale;
  }
}

// Makes 8-bit heights from 0 to 255.
TestImage byte_image(int width, int height, const std::function<double(int, int)>& code) {
  TestImage image = height_image(width, height, [&](int x, int y) { return std::round(code(x, y)) / 255.0; });
  image.type = TypeDesc::UINT8;
  return image;
}

NormalMap read_codes(const TestImage& image, bool dequantize, const char* name = "h.png") {
  const TemporaryFolder folder;
  write_test_image(folder / name, image);
  NormalMapSettings settings;
  settings.bump_format = BumpFormat::kHeight;
  settings.height_scale = 512.0f;
  settings.wrap_s = settings.wrap_t = WrapMode::kClamp;
  settings.dequantize = dequantize;
  settings.repair_share_max = 1.0f;
  return read_map(folder / name, settings);
}

// Returns the mean and the largest angle to the normals of a surface that is given as codes, in degrees.
std::pair<double, double> errors(const NormalMap& map, const std::function<double(int, int)>& code) {
  double sum = 0.0, largest = 0.0;
  for (int row = 0; row < map.height; ++row)
    for (int column = 0; column < map.width; ++column) {
      const auto along = [&](int dx, int dy) {
        const int x0 = std::max(0, column - dx), x1 = std::min(map.width - 1, column + dx);
        const int y0 = std::max(0, row - dy), y1 = std::min(map.height - 1, row + dy);
        return 512.0 / 255.0 * (code(x1, y1) - code(x0, y0)) / std::max(1, x1 - x0 + y1 - y0);
      };
      const auto i = static_cast<std::size_t>(row * map.width + column);
      const glm::dvec3 expected = glm::normalize(glm::dvec3(-along(1, 0), along(0, 1), 1.0));
      const double degrees =
          std::acos(std::min(1.0, glm::dot(expected, glm::dvec3(map.x[i], map.y[i], map.z[i])))) * 180.0 / 3.14159265;
      sum += degrees;
      largest = std::max(largest, degrees);
    }
  return {sum / (map.width * map.height), largest};
}

// Quantized ramps of 7.13 degrees and other slopes are flat, except for texels with a slope of 45.1 degrees.
// Dequantizing turns these surfaces into ramps again.
TEST(HeightField, TerracesAreWarnedOfAndDequantized) {
  const std::function<double(int, int)> ramps[] = {[](int x, int) { return 0.25 * 255.0 * x / 1023.0; },
                                                   [](int x, int y) { return 3.3 + 0.031 * x + 0.043 * y; },
                                                   [](int x, int) { return 200.0 - 0.02 * x; }};
  for (const auto& ramp : ramps) {
    const TestImage image = byte_image(520, 90, ramp);
    const NormalMap terraced = read_codes(image, false);
    ASSERT_FALSE(terraced.report.warnings.empty());
    testing::expect_says(terraced.report.warnings.back(), {"steps of 1/255 (8 bits)", "45.1 degrees", "--dequantize"});
    EXPECT_GT(errors(terraced, ramp).second, 30.0);
    const NormalMap smooth = read_codes(image, true);
    for (const std::string& warning : smooth.report.warnings)
      EXPECT_EQ(warning.find("terraces"), std::string::npos) << warning;  // one ramp is nearly flat
    testing::expect_says(smooth.report.encoding, {"dequantized", "1/255"});
    EXPECT_LT(errors(smooth, ramp).second, 0.5);
  }
}

// 8-bit heights stored as 16 bits or floats are terraces too. Real 16-bit heights, and scales that make steps small,
// are not.
TEST(HeightField, TerracesAreKnownInWiderNumbers) {
  const auto ramp = [](int x, int y) { return 3.3 + 0.031 * x + 0.043 * y; };
  TestImage image = byte_image(200, 100, ramp);
  const auto shifted = [&](double unit) {
    TestImage wide = image;
    wide.type = TypeDesc::UINT16;
    for (float& value : wide.values) value = static_cast<float>(std::round(static_cast<double>(value) * 255.0) * unit);
    return wide;
  };
  for (const double unit : {257.0 / 65535.0, 256.0 / 65535.0}) {
    const std::vector<std::string> found = read_codes(shifted(unit), false).report.warnings;
    ASSERT_EQ(found.size(), 1u);
    testing::expect_says(found[0], {"1/255", "in a wider format", "--dequantize"});
    EXPECT_LT(errors(read_codes(shifted(unit), true), ramp).second, 0.6);
  }
  for (const TypeDesc::BASETYPE type : {TypeDesc::HALF, TypeDesc::FLOAT}) {
    image.type = type;
    EXPECT_EQ(read_codes(image, false, "h.exr").report.warnings.size(), 1u);
  }
  TestImage fine = height_image(200, 100, [&](int x, int y) { return ramp(x, y) / 255.0; });
  fine.type = TypeDesc::UINT16;
  EXPECT_TRUE(read_codes(fine, false).report.warnings.empty());
  const TestImage steep = byte_image(200, 100, [](int x, int) { return 3.0 * std::abs(x % 80 - 40); });
  for (const std::string& warning : read_codes(steep, false).report.warnings)
    EXPECT_EQ(warning.find("terraces"), std::string::npos) << warning;
}

TEST(HeightField, DequantizingWithoutEffectIsSaid) {
  NormalMapSettings settings;
  settings.dequantize = true;
  const TestImage smooth = height_image(64, 48, [](int x, int y) { return 0.3 * std::sin(0.31 * x) + 0.1 * y; });
  testing::expect_says(read_heights(smooth, settings).report.warnings.back(), {"no effect", "--dequantize"});
  const TemporaryFolder folder;
  write_test_image(folder / "n.png", normal_image(64, 48));
  testing::expect_says(read_map(folder / "n.png", settings).report.warnings.front(),
                       {"no effect on a normal map", "--dequantize"});
}

// A map with only five heights is a shape, however many steps of the file's number type separate them. Smoothing would
// remove its cliffs.
TEST(HeightField, AFewLevelsAreNoTerraces) {
  TestImage image = height_image(64, 48, [](int x, int) { return 1000.0 * (x / 13) / 65535.0; });
  image.type = TypeDesc::UINT16;
  const NormalMap map = read_codes(image, true);
  ASSERT_FALSE(map.report.warnings.empty());
  testing::expect_says(map.report.warnings.back(), {"no effect", "--dequantize"});
}

// Curved surfaces keep their shape, a step of two codes stays in place, and every height stays within half a step.
TEST(HeightField, DequantizingKeepsShapesAndEdges) {
  const auto waves = [](int x, int y) { return 127.0 + 20.0 * std::sin(0.05 * x) * std::cos(0.04 * y); };
  const auto [before, before_max] = errors(read_codes(byte_image(256, 256, waves), false), waves);
  const auto [after, after_max] = errors(read_codes(byte_image(256, 256, waves), true), waves);
  EXPECT_GT(before, 10.0);
  EXPECT_LT(after, 1.0);
  const auto mesa = [](int x, int y) { return 20.0 + 0.02 * y + (x >= 60 && x < 90 ? 2.0 : 0.0); };
  const NormalMap map = read_codes(byte_image(150, 100, mesa), true);
  for (const int column : {59, 60, 89, 90}) EXPECT_NEAR(std::abs(slopes(map, column, 50).first), 512.0 / 255.0, 0.05);
  EXPECT_NEAR(slopes(map, 57, 50).first, 0.0, 0.01);
  EXPECT_NEAR(slopes(map, 75, 50).second, -0.02 * 512.0 / 255.0, 0.02);
}

// Maps that are processed in several tiles have no visible borders. The bits are equal with any number of threads and
// with scratch files.
TEST(HeightField, DequantizingInTilesShowsNoBorders) {
  const auto ramp = [](int x, int y) { return 3.3 + 0.031 * x + 0.043 * y; };
  for (const auto& [width, height] : {std::pair{1600, 48}, {48, 1600}}) {
    const TemporaryFolder folder;
    write_test_image(folder / "h.png", byte_image(width, height, ramp));
    NormalMapSettings settings;
    settings.height_scale = 512.0f;
    settings.wrap_s = settings.wrap_t = WrapMode::kClamp;
    settings.dequantize = true;
    const NormalMap one = read_normal_map(folder / "h.png", settings, 1, nullptr);
    EXPECT_LT(errors(one, ramp).second, 0.5);
    const SpillPolicy spill = {std::filesystem::path(folder / "h.png").parent_path().string(), 1 << 12, 64};
    const NormalMapRows many = read_normal_map_rows(folder / "h.png", settings, spill, 3, nullptr);
    std::vector<float> rows(one.x.size());
    many.normals.read_rows(0, 0, height, rows.data());
    EXPECT_EQ(rows, one.x);
  }
}

TEST(HeightField, ThreadCountChangesNoBit) {
  const TemporaryFolder folder;
  write_test_image(folder / "h.exr", height_image(77, 133, [](int x, int y) { return std::sin(0.3 * x * y); }));
  const NormalMap one = read_normal_map(folder / "h.exr", {}, 1, nullptr);
  const NormalMap many = read_normal_map(folder / "h.exr", {}, 5, nullptr);
  EXPECT_EQ(one.x, many.x);
  EXPECT_EQ(one.z, many.z);
  EXPECT_EQ(one.report.encoding, many.report.encoding);
}

}  // namespace
}  // namespace multum::testing
