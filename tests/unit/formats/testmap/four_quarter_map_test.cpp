// SPDX-License-Identifier: Apache-2.0
// Tests that the test map matches its description. The map is reproducible, normals have unit length, and each quarter
// has the stated statistics.
#include "host/formats/testmap/four_quarter_map.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

struct QuarterStatistics {
  double slope_x_rms = 0, slope_max = 0, flat_share = 0;
};

QuarterStatistics statistics(const NormalMap& map, int column_begin, int row_begin, int width, int height) {
  QuarterStatistics result;
  for (int row = row_begin; row < row_begin + height; ++row) {
    for (int column = column_begin; column < column_begin + width; ++column) {
      const auto i = static_cast<std::size_t>(row * map.width + column);
      const double sx = static_cast<double>(map.x[i]) / static_cast<double>(map.z[i]);
      const double sy = static_cast<double>(map.y[i]) / static_cast<double>(map.z[i]);
      result.slope_x_rms += sx * sx;
      result.slope_max = std::max(result.slope_max, std::hypot(sx, sy));
      result.flat_share += std::hypot(sx, sy) < 1e-3 ? 1.0 : 0.0;
    }
  }
  result.slope_x_rms = std::sqrt(result.slope_x_rms / (width * height));
  result.flat_share /= width * height;
  return result;
}

TEST(FourQuarterMap, SameSeedSameMap) {
  const FourQuarterMap a = make_four_quarter_map(64, 7);
  const FourQuarterMap b = make_four_quarter_map(64, 7);
  const FourQuarterMap c = make_four_quarter_map(64, 8);
  EXPECT_EQ(a.normals.x, b.normals.x);
  EXPECT_EQ(a.albedo.b, b.albedo.b);
  EXPECT_NE(a.normals.x, c.normals.x);
  for (int i = 0; i < 32 * 64; ++i)  // the seed changes only one quarter
    EXPECT_EQ(a.normals.x[static_cast<std::size_t>(i)], c.normals.x[static_cast<std::size_t>(i)]);
}

TEST(FourQuarterMap, UnitNormalsAtAnyEvenSize) {
  for (const int size : {16, 30, 250}) {
    const NormalMap map = make_four_quarter_map(size, 1).normals;
    ASSERT_EQ(map.x.size(), static_cast<std::size_t>(size * size));
    for (std::size_t i = 0; i < map.x.size(); ++i)
      ASSERT_NEAR(std::sqrt(map.x[i] * map.x[i] + map.y[i] * map.y[i] + map.z[i] * map.z[i]), 1.0, 3e-7);
  }
}

TEST(FourQuarterMap, AQuarterAloneFillsTheMap) {
  const int half = 32;
  const NormalMap four = make_four_quarter_map(2 * half, 7).normals;
  const std::array<std::pair<Quarter, int>, 4> quarters = {{{Quarter::kArmour, 0},
                                                            {Quarter::kRings, half},
                                                            {Quarter::kGrooves, 2 * half * half},
                                                            {Quarter::kNoise, 2 * half * half + half}}};
  for (const auto& [quarter, first] : quarters) {
    const NormalMap alone = make_four_quarter_map(half, 7, quarter).normals;
    ASSERT_EQ(alone.width, half);
    ASSERT_EQ(alone.y.size(), static_cast<std::size_t>(half * half));
    for (int row = 0; row < half; ++row)
      for (int column = 0; column < half; ++column)
        ASSERT_EQ(alone.y[static_cast<std::size_t>(row * half + column)],
                  four.y[static_cast<std::size_t>(first + row * 2 * half + column)]);
  }
}

TEST(FourQuarterMap, QuartersAreAsDescribed) {
  const int size = 480;  // whole periods of 24 and 12 in a quarter of 240
  const NormalMap map = make_four_quarter_map(size, 3).normals;
  const int half = size / 2;
  const QuarterStatistics armour = statistics(map, 0, 0, half, half);
  EXPECT_NEAR(armour.slope_max, std::sqrt(0.9025 / (1 - 0.9025)), 0.2);
  EXPECT_NEAR(armour.flat_share, 1.0 - 0.9025 * 3.14159265 / 4.0, 0.02);  // outside the circles
  const QuarterStatistics rings = statistics(map, half, 0, half, half);
  EXPECT_NEAR(rings.slope_max, 1.2, 0.01);
  EXPECT_NEAR(rings.flat_share, 0.45, 0.02);
  const QuarterStatistics grooves = statistics(map, 0, half, half, half);
  EXPECT_NEAR(grooves.slope_max, 1.0, 1e-3);
  EXPECT_NEAR(grooves.flat_share, 0.2, 0.01);
  EXPECT_NEAR(grooves.slope_x_rms, std::sqrt(0.8 * 0.75), 0.01);
  // An rms of 0.45 times a gain of 0.4 .. 1.6 is 0.45 sqrt(1 + 1.2^2 / 12); the strips have the extreme gains.
  EXPECT_NEAR(statistics(map, half, half, half, half).slope_x_rms, 0.45 * std::sqrt(1.0 + 0.12), 0.02);
  EXPECT_NEAR(statistics(map, half, half, half / 8, half).slope_x_rms, 0.45 * 0.475, 0.02);
  EXPECT_NEAR(statistics(map, size - half / 8, half, half / 8, half).slope_x_rms, 0.45 * 1.525, 0.05);
}

// In this map green points down. On the right side of a dome, normals lean to the right. y increases downwards.
TEST(FourQuarterMap, ArmourIsOfDomes) {
  const int side = 48, period = 24;
  const NormalMap map = make_four_quarter_map(side, 3, Quarter::kArmour).normals;
  const auto at = [&](int column, int row) { return static_cast<std::size_t>(row * side + column); };
  const int middle = period / 2, aside = period / 4;
  EXPECT_GT(map.x[at(middle + aside, middle)], 0.2f);
  EXPECT_LT(map.x[at(middle - aside, middle)], -0.2f);
  EXPECT_GT(map.y[at(middle, middle + aside)], 0.2f);
  EXPECT_LT(map.y[at(middle, middle - aside)], -0.2f);
}

// White noise under a Gaussian of sigma has the autocorrelation exp(-d^2 / (4 sigma^2)). Each row has one gain, so
// slopes along x keep this autocorrelation from row to row.
TEST(FourQuarterMap, NoiseHasItsSigma) {
  const int size = 512;
  const NormalMap map = make_four_quarter_map(size, 5).normals;
  double product = 0.0, square = 0.0;
  for (int row = size / 2; row + 1 < size; ++row) {
    for (int column = size / 2; column < size; ++column) {
      const auto i = static_cast<std::size_t>(row * size + column);
      const auto below = i + static_cast<std::size_t>(size);
      const double slope = static_cast<double>(map.x[i]) / static_cast<double>(map.z[i]);
      product += slope * static_cast<double>(map.x[below]) / static_cast<double>(map.z[below]);
      square += slope * slope;
    }
  }
  EXPECT_NEAR(product / square, std::exp(-1.0 / (4.0 * 0.8 * 0.8)), 0.02);
}

TEST(FourQuarterMap, FilesReadBackAsTheSameMap) {
  const TemporaryFolder folder;
  const FourQuarterMap map = make_four_quarter_map(128, 11);
  write_four_quarter_map(128, 11, folder / "four");
  NormalMapSettings settings;
  settings.green = GreenAxis::kUp;
  const NormalMap read = read_map(folder / "four_normal.png", settings);
  ASSERT_EQ(read.width, 128);
  for (std::size_t i = 0; i < read.x.size(); ++i) {
    ASSERT_NEAR(read.x[i], map.normals.x[i], 2e-7);
    ASSERT_NEAR(read.y[i], map.normals.y[i], 2e-7);
    ASSERT_NEAR(read.z[i], map.normals.z[i], 2e-7);
  }
  const ColourMap albedo = read_albedo_map(folder / "four_albedo.png", 128, 128, 2);
  for (std::size_t i = 0; i < albedo.r.size(); ++i) ASSERT_NEAR(albedo.g[i], map.albedo.g[i], 2e-5);
  EXPECT_NE(read_map(folder / "four_normal.png").report.encoding.find("green down"), std::string::npos);
  write_four_quarter_map(128, 11, folder / "four", std::nullopt, GreenAxis::kUp);
  const NormalMap flipped = read_map(folder / "four_normal.png");
  EXPECT_NE(flipped.report.encoding.find("green up"), std::string::npos);
  for (std::size_t i = 0; i < flipped.y.size(); ++i) ASSERT_NEAR(flipped.y[i], -map.normals.y[i], 2e-7);
  int file_count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder / ".")) ++file_count;
  EXPECT_EQ(file_count, 2);
  expect_error(ErrorCode::kEnvironment, {"absent"}, [&] { write_four_quarter_map(128, 11, folder / "absent/four"); });
}

}  // namespace
}  // namespace multum::testing
