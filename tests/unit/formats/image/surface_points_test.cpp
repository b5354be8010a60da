// SPDX-License-Identifier: Apache-2.0
// Tests points of the surface between texels. Their means must equal the means of the surface that a renderer
// interpolates.
#include "host/formats/image/surface_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using PlaneRows = std::array<std::vector<float>, 3>;

PlaneRows plane_rows_of(const PlaneStore& store) {
  const auto count = static_cast<std::size_t>(store.width()) * static_cast<std::size_t>(store.height());
  PlaneRows planes = {std::vector<float>(count), std::vector<float>(count), std::vector<float>(count)};
  store.read_rows(0, store.height(), {planes[0].data(), planes[1].data(), planes[2].data()});
  return planes;
}

PlaneStore filled_store(int width, int height, const std::function<std::array<float, 3>(int x, int y)>& texel) {
  PlaneStore store(width, height);
  for (int y = 0; y < height; ++y) {
    PlaneRows row;
    for (int x = 0; x < width; ++x) {
      const std::array<float, 3> value = texel(x, y);
      for (std::size_t p = 0; p < 3; ++p) row[p].push_back(value[p]);
    }
    store.write_rows(y, 1, {row[0].data(), row[1].data(), row[2].data()});
  }
  return store;
}

std::array<float, 3> unit(float x, float y, float z) {
  const float length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

// Returns a pattern of 5 x 7 values, which is repeated until each value has had each point once.
constexpr int kPatternWidth = 5, kPatternHeight = 7, kTiledWidth = 20, kTiledHeight = 28;

std::vector<double> pattern() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> values(-1.0, 1.0);
  std::vector<double> texels(kPatternWidth * kPatternHeight);
  for (double& texel : texels) texel = static_cast<double>(static_cast<float>(values(random)));
  return texels;
}

double pattern_at(const std::vector<double>& texels, int x, int y) {
  return texels[static_cast<std::size_t>(y % kPatternHeight * kPatternWidth + x % kPatternWidth)];
}

// Returns the mean of v^power over the surface by Simpson's rule between texel centres; exact up to power 3.
double surface_moment(const std::vector<double>& texels, int power) {
  constexpr double kWeights[] = {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0};
  double sum = 0.0;
  for (int y = 0; y < kPatternHeight; ++y)
    for (int x = 0; x < kPatternWidth; ++x)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const double u = 0.5 * i, v = 0.5 * j;
          const double value = (1.0 - v) * ((1.0 - u) * pattern_at(texels, x, y) + u * pattern_at(texels, x + 1, y)) +
                               v * ((1.0 - u) * pattern_at(texels, x, y + 1) + u * pattern_at(texels, x + 1, y + 1));
          sum += kWeights[i] * kWeights[j] * std::pow(value, power);
        }
  return sum / (kPatternWidth * kPatternHeight);
}

TEST(SurfacePointsTest, MomentsUpToTheThirdAreTheSurfaces) {
  const std::vector<double> texels = pattern();
  const PlaneStore values = filled_store(kTiledWidth, kTiledHeight, [&](int x, int y) {
    const auto value = static_cast<float>(pattern_at(texels, x, y));
    return std::array<float, 3>{value, -value, 0.5f * value};
  });
  const PlaneRows points = plane_rows_of(surface_values(values, {}, {}, 1, nullptr));
  for (int power = 1; power <= 3; ++power) {
    double sum = 0.0, texel_sum = 0.0;
    for (const float value : points[0]) sum += std::pow(static_cast<double>(value), power);
    for (const double value : texels) texel_sum += std::pow(value, power);
    const double wanted = surface_moment(texels, power);
    EXPECT_NEAR(sum / (kTiledWidth * kTiledHeight), wanted, 1e-7) << "power " << power;
    if (power > 1) {
      EXPECT_GT(std::abs(texel_sum / static_cast<double>(texels.size()) - wanted), 0.01) << "power " << power;
    }
  }
  EXPECT_FLOAT_EQ(points[1][17], -points[0][17]);
  EXPECT_FLOAT_EQ(points[2][17], 0.5f * points[0][17]);
}

TEST(SurfacePointsTest, NormalsAreUnitAndShortenedOnesKeepTheirLengths) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> slopes(-1.0f, 1.0f);
  PlaneStore normals = filled_store(16, 12, [&](int, int) { return unit(slopes(random), slopes(random), 1.0f); });
  PlaneRows points = plane_rows_of(surface_normals(normals, {}, {}, 1, nullptr));
  for (std::size_t i = 0; i < points[0].size(); ++i)
    EXPECT_NEAR(std::hypot(points[0][i], points[1][i], points[2][i]), 1.0f, 1e-6f);
  // Between two normals with the same direction and different lengths, the direction stays the same, and the length is
  // interpolated.
  PlaneStore rough = filled_store(8, 8, [](int x, int) {
    const float length = x < 4 ? 0.5f : 1.0f;
    return std::array<float, 3>{0.6f * length, 0.0f, 0.8f * length};
  });
  rough.set_shortened(true);
  const PlaneStore between = surface_normals(rough, {WrapMode::kClamp, WrapMode::kClamp}, {}, 1, nullptr);
  EXPECT_TRUE(between.is_shortened());
  points = plane_rows_of(between);
  const float expected[] = {0.5f, 0.5f, 0.5f, 0.60566f, 0.89434f, 1.0f, 1.0f, 1.0f};
  for (std::size_t x = 0; x < 8; ++x) {
    const std::size_t i = 8 + x;  // in row 1, where texels 3 and 4 use each other as neighbours
    EXPECT_NEAR(std::hypot(points[0][i], points[1][i], points[2][i]), expected[x], 1e-5f) << x;
    EXPECT_NEAR(points[0][i] / points[2][i], 0.75f, 1e-5f);
  }
}

TEST(SurfacePointsTest, BordersContinueAsTheMapDoes) {
  const PlaneStore ramp = filled_store(4, 4, [](int x, int) {
    return std::array<float, 3>{static_cast<float>(x), 0, 0};
  });
  const auto first_of_row_1 = [&](WrapMode mode) {  // its neighbour is beyond the border
    return plane_rows_of(surface_values(ramp, {mode, WrapMode::kPeriodic}, {}, 1, nullptr))[0][4];
  };
  EXPECT_FLOAT_EQ(first_of_row_1(WrapMode::kPeriodic), 0.211324865f * 3.0f);
  for (const WrapMode mode : {WrapMode::kClamp, WrapMode::kMirror, WrapMode::kBlack})
    EXPECT_FLOAT_EQ(first_of_row_1(mode), 0.0f);
}

// A step along an axis has the same width everywhere, so each column has the same number of points on its slope.
TEST(SurfacePointsTest, StepsHaveAsManyPointsWhereverTheyLie) {
  for (int at = 1; at < 8; ++at)
    for (const bool along_x : {false, true}) {
      const PlaneStore step = filled_store(8, 8, [&](int x, int y) {
        return std::array<float, 3>{(along_x ? x : y) < at ? 0.0f : 1.0f, 0, 0};
      });
      const PlaneRows points =
          plane_rows_of(surface_values(step, {WrapMode::kClamp, WrapMode::kClamp}, {}, 1, nullptr));
      const auto on_slope =
          std::count_if(points[0].begin(), points[0].end(), [](float value) { return value > 0.01f && value < 0.99f; });
      EXPECT_EQ(on_slope, 8) << at << (along_x ? " along x" : " along y");
    }
}

// Four normals with weights 0.622, 0.167, 0.167 and 0.045: (0.464 * 0.622 + 0.045) - 2 * 0.167 is 0.
TEST(SurfacePointsTest, NormalsThatCancelGiveTheNearestOne) {
  constexpr float kOwn = 0.46410162f;  // (2 g (1 - g) - g^2) / (1 - g)^2, g = 0.2113
  for (const float sign : {1.0f, -1.0f}) {
    PlaneStore opposed = filled_store(4, 4, [sign](int x, int y) {
      const bool is_own = x == 0 && y == 0, is_diagonal = x == 1 && y == 1;
      return std::array<float, 3>{sign * (is_own ? kOwn : is_diagonal ? 1.0f : -1.0f), 0.0f, 0.0f};
    });
    opposed.set_shortened(true);
    const PlaneRows sums = plane_rows_of(surface_values(opposed, {}, {}, 1, nullptr));
    ASSERT_NEAR(sums[0][0], 0.0f, 2e-7f);
    const PlaneRows points = plane_rows_of(surface_normals(opposed, {}, {}, 1, nullptr));
    EXPECT_NEAR(points[0][0], sign * (0.62201f * kOwn + 0.37799f), 1e-4f)
        << "the point is as long as the four normals and as its own texel";
  }
}

TEST(SurfacePointsTest, ThreadsAndScratchFilesChangeNothing) {
  const testing::TemporaryFolder folder;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> slopes(-1.0f, 1.0f);
  const PlaneStore normals =
      filled_store(37, 200, [&](int, int) { return unit(slopes(random), slopes(random), 1.0f); });
  const SpillPolicy scratch = {folder.path(), 0};
  EXPECT_EQ(plane_rows_of(surface_normals(normals, {}, {}, 1, nullptr)),
            plane_rows_of(surface_normals(normals, {}, scratch, 3, nullptr)));
}

}  // namespace
}  // namespace multum
