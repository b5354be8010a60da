// SPDX-License-Identifier: Apache-2.0
// Tests footprints: their distribution, the texels that the filter reads for them, and their averages, compared with
// the definition in double precision (host/lab/reference/pixel_footprint.h).
#include "host/bakes/accuracy/footprints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <map>
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

// The two coarsest octaves of this map have fewer footprints. Sizes, elongations and positions are stratified, which
// means that each range is divided into equal parts with one footprint per part.
TEST(Footprints, AreSpreadEvenly) {
  constexpr int kMost = 64, kWidth = 300, kHeight = 100;
  const std::vector<Footprint> all = choose_footprints(kWidth, kHeight, {kMost, 1, 7});
  ASSERT_EQ(footprint_octave_count(kWidth, kHeight), 8);
  std::size_t first = 0;
  for (int octave = 1; octave < 8; ++octave) {
    const int count = octave < 6 ? kMost : kFootprintsMin;
    const std::size_t end = first + static_cast<std::size_t>(count);
    ASSERT_LE(end, all.size());
    std::vector<int> sizes(static_cast<std::size_t>(count)), elongations(sizes), columns(3);
    double turned = 0.0;
    for (std::size_t i = first; i < end; ++i) {
      const Footprint& one = all[i];
      EXPECT_EQ(one.octave, octave);
      const double longer = glm::length(one.longer_side), shorter = glm::length(one.shorter_side);
      EXPECT_NEAR(glm::dot(one.longer_side, one.shorter_side), 0.0, 1e-9 * longer * shorter);
      ++sizes.at(static_cast<std::size_t>(count * (std::log2(shorter) - octave)));
      ++elongations.at(
          static_cast<std::size_t>(count * std::log(longer / shorter) / std::log(FootprintSettings{}.elongation_max)));
      ASSERT_TRUE(one.centre.x >= 0.0 && one.centre.x < kWidth && one.centre.y >= 0.0 && one.centre.y < kHeight);
      ++columns.at(static_cast<std::size_t>(one.centre.x / 100.0));
      turned += one.longer_side.y / longer / count;
    }
    EXPECT_EQ(std::count(sizes.begin(), sizes.end(), 1), count);
    EXPECT_EQ(std::count(elongations.begin(), elongations.end(), 1), count);
    for (const int column : columns) EXPECT_NEAR(column, count / 3.0, 4.0);
    EXPECT_NEAR(turned, 2.0 / M_PI, 0.25);  // the mean sine of evenly spread directions
    first = end;
  }
  EXPECT_EQ(first, all.size());
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

TEST(Footprints, FewOfThoseThatCoverMuchOfTheMap) {
  // A footprint of octave k has 2^(2 k + 2) texels on average.
  EXPECT_EQ(footprint_count(5, 512, 512, 256), 256);
  EXPECT_EQ(footprint_count(6, 512, 512, 256), 256);
  EXPECT_EQ(footprint_count(7, 512, 512, 256), 64);
  EXPECT_EQ(footprint_count(8, 512, 512, 256), kFootprintsMin);
  EXPECT_EQ(footprint_count(7, 512, 1024, 256), 128);
  EXPECT_EQ(footprint_count(8, 512, 512, 4), 4);
  EXPECT_EQ(footprint_count(8, 512, 512, 0), 0);
  EXPECT_EQ(footprint_count(14, 16384, 1, 256), kFootprintsMin);
  std::map<int, int> counts;
  for (const Footprint& one : choose_footprints(512, 512, {})) ++counts[one.octave];
  for (const auto& [octave, count] : counts) EXPECT_EQ(count, footprint_count(octave, 512, 512, 256)) << octave;
  EXPECT_EQ(counts.size(), 9u);
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
      AlignedRow scratch(averages.scratch_length());
      const std::vector<double> twos(static_cast<std::size_t>(size.width), 2.0);
      for (int y = 0; y < size.height; ++y) {
        const double* row = plane.values.data() + std::ptrdiff_t{y} * size.width;
        if (!averages.needs_row(y)) continue;
        averages.add_rows(y, {row}, nullptr, scratch, sums.data(), 2);
        averages.add_rows(y, {twos.data()}, row, scratch, doubled.data(), 2);
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
    AlignedRow scratch(averages.scratch_length());
    for (int y = 0; y < size.height; ++y) {
      if (!averages.needs_row(y)) continue;
      std::vector<const double*> rows;
      for (const reference::ValuePlane& plane : planes)
        rows.push_back(plane.values.data() + std::ptrdiff_t{y} * size.width);
      const double* const factors = rows.back();
      rows.pop_back();
      averages.add_rows(y, rows, factors, scratch, together.data(), kPlanes);
      for (std::size_t p = 0; p < kPlanes; ++p)
        averages.add_rows(y, {rows[p]}, factors, scratch, single.data() + p, kPlanes);
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

// Octaves have equal weights, so a footprint of an octave with half as many footprints counts twice.
TEST(FootprintErrors, OctavesOfFewFootprintsWeighTheSame) {
  const ErrorSum a = {2.5, 5.0, 1.0}, b = {1.1, 5.0, 1.0}, c = {0.9, 4.0, 1.0}, d = {1.6, 8.0, 1.0};
  std::vector<Footprint> few(3), many(4);
  few[2].octave = many[2].octave = many[3].octave = 1;
  const FootprintError of_few = footprint_error(AccuracyBrdf::lambert(), few, {a, b, c});
  const FootprintError of_many = footprint_error(AccuracyBrdf::lambert(), many, {a, b, c, c});
  EXPECT_DOUBLE_EQ(of_few.error, of_many.error);
  EXPECT_DOUBLE_EQ(of_few.percentile_95, of_many.percentile_95);
  EXPECT_EQ(of_few.sample_count, 3);
  // R is (2.5 + 1.1 + 2 0.9) / (5 + 5 + 2 4) = 0.3, and only the first octave has a spread: 1 and -0.4 about 0.3.
  EXPECT_DOUBLE_EQ(of_few.error, 0.3);
  EXPECT_NEAR(of_few.confidence, 1.96 * std::sqrt(2.0 * 2.0 * 0.49) / 18.0, 1e-12);
  // With 1 and 20 footprints, the single one has half of the weight, so its error is the 95th percentile.
  std::vector<Footprint> uneven(21);
  uneven[20].octave = 1;
  std::vector<ErrorSum> sums(20, c);
  sums.push_back(a);
  EXPECT_DOUBLE_EQ(footprint_error(AccuracyBrdf::lambert(), uneven, sums).percentile_95, 0.5);
  sums[20] = d;
  EXPECT_DOUBLE_EQ(footprint_error(AccuracyBrdf::lambert(), uneven, sums).percentile_95, 0.225);
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
