// SPDX-License-Identifier: Apache-2.0
// Tests footprints: their distribution, the texels that the filter reads for them, and their averages, compared with
// the definition in double precision (host/lab/reference/pixel_footprint.h).
#include "host/bakes/accuracy/footprints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <vector>

#include "host/bakes/accuracy/footprint_averages.h"
#include "host/bakes/accuracy/footprint_error.h"
#include "host/foundation/base/split_mix.h"
#include "host/lab/reference/pixel_footprint.h"

namespace multum {
namespace {

constexpr WrapMode kWrapModes[] = {WrapMode::kPeriodic, WrapMode::kClamp, WrapMode::kMirror, WrapMode::kBlack};

std::vector<PlaneSize> pyramid_sizes(int width, int height) {
  std::vector<PlaneSize> levels;
  for (int l = 0; (std::max(width, height) >> l) > 0; ++l)
    levels.push_back({std::max(1, width >> l), std::max(1, height >> l)});
  return levels;
}

reference::ValuePlane random_plane(PlaneSize size, std::uint64_t seed) {
  reference::ValuePlane plane{size.width, size.height, {}};
  SplitMix64 random(seed);
  for (int i = 0; i < size.width * size.height; ++i) plane.values.push_back(random.uniform());
  return plane;
}

reference::PixelRectangle rectangle_of(const Footprint& footprint) {
  return {footprint.centre, footprint.longer_side, footprint.shorter_side};
}

// Every octave has equally many footprints. Sizes, elongations and positions are stratified, which means that each
// range is divided into equal parts with one footprint per part.
TEST(Footprints, AreSpreadEvenly) {
  constexpr int kCount = 64, kWidth = 300, kHeight = 100;
  const std::vector<Footprint> all = choose_footprints(kWidth, kHeight, {kCount, 1, 7});
  ASSERT_EQ(footprint_octave_count(kWidth, kHeight), 8);
  ASSERT_EQ(all.size(), 7u * kCount);
  for (std::size_t first = 0; first < all.size(); first += kCount) {
    const int octave = 1 + static_cast<int>(first) / kCount;
    std::vector<int> sizes(kCount), elongations(kCount), columns(3);
    double turned = 0.0;
    for (std::size_t i = first; i < first + kCount; ++i) {
      const Footprint& one = all[i];
      EXPECT_EQ(one.octave, octave);
      const double longer = glm::length(one.longer_side), shorter = glm::length(one.shorter_side);
      EXPECT_NEAR(glm::dot(one.longer_side, one.shorter_side), 0.0, 1e-9 * longer * shorter);
      ++sizes.at(static_cast<std::size_t>(kCount * (std::log2(shorter) - octave)));
      ++elongations.at(
          static_cast<std::size_t>(kCount * std::log(longer / shorter) / std::log(FootprintSettings{}.elongation_max)));
      ASSERT_TRUE(one.centre.x >= 0.0 && one.centre.x < kWidth && one.centre.y >= 0.0 && one.centre.y < kHeight);
      ++columns.at(static_cast<std::size_t>(one.centre.x / 100.0));
      turned += one.longer_side.y / longer / kCount;
    }
    EXPECT_EQ(std::count(sizes.begin(), sizes.end(), 1), kCount);
    EXPECT_EQ(std::count(elongations.begin(), elongations.end(), 1), kCount);
    for (const int column : columns) EXPECT_NEAR(column, kCount / 3.0, 4.0);
    EXPECT_NEAR(turned, 2.0 / M_PI, 0.25);  // the mean sine of evenly spread directions
  }
  EXPECT_EQ(choose_footprints(1, 1, {5}).size(), 5u) << "one octave suffices, even for a map of one texel";
  EXPECT_TRUE(choose_footprints(16, 16, {0}).empty());
}

// Taps that are shaded one by one read the same texels, which are grouped by point. The mean of the taps has the same
// weights.
void expect_same_tap_by_tap(const std::vector<FilterTap>& averaged, const Footprint& footprint,
                            const std::vector<PlaneSize>& sizes, const FootprintSettings& settings) {
  const double longer = glm::length(footprint.longer_side), shorter = glm::length(footprint.shorter_side);
  std::vector<FilterTap> taps;
  const int count = append_filter_taps(footprint, sizes, settings, taps);
  EXPECT_EQ(count, settings.filter.tap_count(longer, shorter));
  ASSERT_EQ(taps.size(), averaged.size());
  for (std::size_t i = 0; i < taps.size(); ++i) {
    EXPECT_EQ(taps[i].level, averaged[i].level);
    EXPECT_EQ(taps[i].texel, averaged[i].texel);
    EXPECT_NEAR(taps[i].weight, count * averaged[i].weight, 1e-12);
    EXPECT_TRUE(taps[i].point >= (i > 0 ? taps[i - 1].point : 0) && taps[i].point < count);
  }
}

TEST(Footprints, AreFilteredAsTheGlDoes) {
  for (const PlaneSize size : {PlaneSize{64, 64}, PlaneSize{37, 11}}) {
    const std::vector<PlaneSize> sizes = pyramid_sizes(size.width, size.height);
    std::vector<reference::ValuePlane> levels;
    for (std::size_t l = 0; l < sizes.size(); ++l) levels.push_back(random_plane(sizes[l], 100 + l));
    for (const WrapMode mode : kWrapModes) {
      const FootprintSettings settings{20, 0, 3, mode, mode, {3, 0.25, false}};
      FootprintSettings shaded = settings;
      shaded.filter.shades_taps = true;
      for (const Footprint& footprint : choose_footprints(size.width, size.height, settings)) {
        std::vector<FilterTap> taps;
        EXPECT_EQ(append_filter_taps(footprint, sizes, settings, taps), 1);
        double sum = 0.0, weights = 0.0;
        for (const FilterTap& tap : taps) {
          sum +=
              tap.weight * levels[static_cast<std::size_t>(tap.level)].values.at(static_cast<std::size_t>(tap.texel));
          weights += tap.weight;
        }
        EXPECT_NEAR(sum, filtered_value(levels, rectangle_of(footprint), {mode, mode}, 3, 0.25), 1e-12);
        if (mode == WrapMode::kBlack) EXPECT_LE(weights, 1.0 + 1e-12);
        else EXPECT_NEAR(weights, 1.0, 1e-12);
        expect_same_tap_by_tap(taps, footprint, sizes, shaded);
      }
    }
  }
}

// The points of the definition are 1/400 of a side apart. On random values, the definition itself has an error of up to
// 0.002.
TEST(Footprints, AveragesAreThoseOfTheDefinition) {
  for (const PlaneSize size : {PlaneSize{32, 32}, PlaneSize{45, 13}, PlaneSize{1, 1}, PlaneSize{100, 3}}) {
    const reference::ValuePlane plane = random_plane(size, 5);
    for (const WrapMode mode : kWrapModes) {
      SCOPED_TRACE(wrap_mode_name(mode));
      const FootprintSettings settings{4, 0, 11, mode, mode, {}};
      const FootprintAverages averages(choose_footprints(size.width, size.height, settings), size.width, size.height,
                                       settings);
      std::vector<double> sums(2 * averages.footprints().size());
      std::vector<double> doubled(sums.size());  // the average of a product
      std::vector<double> scratch(averages.scratch_length());
      const std::vector<double> twos(static_cast<std::size_t>(size.width), 2.0);
      for (int y = 0; y < size.height; ++y) {
        const double* row = plane.values.data() + std::ptrdiff_t{y} * size.width;
        if (!averages.needs_row(y)) continue;
        averages.add_rows(y, {row}, nullptr, scratch.data(), sums.data(), 2);
        averages.add_rows(y, {twos.data()}, row, scratch.data(), doubled.data(), 2);
      }
      for (std::size_t i = 0; i < averages.footprints().size(); ++i) {
        const Footprint& one = averages.footprints()[i];
        EXPECT_NEAR(sums[2 * i], rectangle_average(plane, rectangle_of(one), {mode, mode}, 400), 0.003)
            << "octave " << one.octave;
        EXPECT_NEAR(doubled[2 * i], 2.0 * sums[2 * i], 1e-12);
        EXPECT_EQ(sums[2 * i + 1], 0.0) << "of another value";
      }
    }
  }
}

// Planes that are added together have the same sums, bit for bit, as planes that are added one by one.
TEST(Footprints, SeveralPlanesAreAddedAsOneByOne) {
  for (const PlaneSize size : {PlaneSize{33, 32}, PlaneSize{2000, 4}}) {  // many lines per row, and few
    const FootprintSettings settings{4, 0, 11, WrapMode::kPeriodic, WrapMode::kMirror, {}};
    const FootprintAverages averages(choose_footprints(size.width, size.height, settings), size.width, size.height,
                                     settings);
    constexpr std::size_t kPlanes = 6;
    std::vector<reference::ValuePlane> planes;
    for (std::uint32_t p = 0; p <= kPlanes; ++p) planes.push_back(random_plane(size, 20 + p));
    std::vector<double> together(kPlanes * averages.footprints().size()), single(together.size());
    std::vector<double> scratch(averages.scratch_length());
    for (int y = 0; y < size.height; ++y) {
      if (!averages.needs_row(y)) continue;
      std::vector<const double*> rows;
      for (const reference::ValuePlane& plane : planes)
        rows.push_back(plane.values.data() + std::ptrdiff_t{y} * size.width);
      const double* const factors = rows.back();
      rows.pop_back();
      averages.add_rows(y, rows, factors, scratch.data(), together.data(), kPlanes);
      for (std::size_t p = 0; p < kPlanes; ++p)
        averages.add_rows(y, {rows[p]}, factors, scratch.data(), single.data() + p, kPlanes);
    }
    EXPECT_EQ(together, single);
    EXPECT_NE(together, std::vector<double>(together.size()));
  }
}

// The values for two octaves, with two footprints each, are computed by hand. R is 6 / 20. The residuals d - R t are 1
// and -0.4 in one octave, and 0 and -0.6 in the other.
TEST(FootprintErrors, AreARatioWithItsInterval) {
  std::vector<Footprint> footprints(4);
  footprints[2].octave = footprints[3].octave = 1;
  const std::vector<ErrorSum> sums = {{2.5, 5.0, 1.0}, {1.1, 5.0, 1.0}, {1.5, 5.0, 1.0}, {0.9, 5.0, 1.0}};
  const FootprintError error = footprint_error(AccuracyBrdf::lambert(), footprints, sums);
  EXPECT_DOUBLE_EQ(error.error, 0.3);
  // The sums of squares about the mean of each octave are 2 0.7^2 and 2 0.3^2. Both are multiplied by n / (n - 1) = 2.
  EXPECT_NEAR(error.confidence, 1.96 * std::sqrt(2.0 * (2.0 * 0.49 + 2.0 * 0.09)) / 20.0, 1e-12);
  EXPECT_EQ(error.worst_octave, 0);
  EXPECT_DOUBLE_EQ(error.worst_octave_error, 0.36);
  EXPECT_DOUBLE_EQ(error.percentile_95, 0.5);
  EXPECT_EQ(error.sample_count, 4);
}

// Where the highlight has no light, differences are relative to a hundredth of a white diffuse surface.
TEST(FootprintErrors, OfNextToNothingAreFinite) {
  const std::vector<Footprint> footprints(2);
  const FootprintError error =
      footprint_error(AccuracyBrdf::lambert(), footprints, {{1e-20, 1e-30, 1.0}, {0.0, 0.0, 1.0}});
  EXPECT_LT(error.error, 1e-15);
  EXPECT_LT(error.percentile_95, 1e-15);
}

}  // namespace
}  // namespace multum
