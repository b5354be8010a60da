// SPDX-License-Identifier: Apache-2.0
// Tests measured errors on maps with known errors. This includes files without their finest levels, which the normal
// map provides. The result does not depend on the order in which a meter gets its rows.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <random>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/accuracy/models/accuracy_model.h"
#include "host/bakes/pyramid/mip_coverage.h"
#include "host/foundation/base/error.h"
#include "tests/fixtures/test_device.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::test_device;

constexpr int kWidth = 22, kHeight = 9;  // levels of 22 x 9, 11 x 4, 5 x 2, 2 x 1, 1 x 1

double uniform(std::mt19937& random) { return static_cast<double>(random() >> 8) * 0x1p-24 * 2.0 - 1.0; }

NormalMap random_map(unsigned seed, double slope) {
  std::mt19937 random(seed);
  return testing::make_map(kWidth, kHeight, [&](int, int) {
    const double x = slope * uniform(random), y = slope * uniform(random);
    return glm::normalize(glm::dvec3(x, y, 1.0));
  });
}

ColourMap random_colours(unsigned seed, double contrast) {
  std::mt19937 random(seed);
  ColourMap map;
  map.width = kWidth;
  map.height = kHeight;
  for (int i = 0; i < kWidth * kHeight; ++i)
    for (std::vector<float>* plane : {&map.r, &map.g, &map.b})
      plane->push_back(static_cast<float>(0.5 + 0.5 * contrast * uniform(random)));
  return map;
}

// Returns one lobe per texel, which in every level is the average of the covered texels. Levels that a file leaves out
// are drawn in the same way.
MovmfMipmap average_lobes(const NormalMap& map, const ColourMap& albedo) {
  MovmfMipmap mipmap;
  mipmap.header.encoding = StorageEncoding::kFloat;
  for (int l = 0; l < mip_level_count(kWidth, kHeight); ++l) {
    MovmfLevel level{mip_level_size(kWidth, l), mip_level_size(kHeight, l), {{}}, {{}}};
    const auto average = [&](const std::vector<float>& plane) {
      return average_over_texels({plane.begin(), plane.end()}, {kWidth, kHeight}, {level.width, level.height}, 1);
    };
    const std::vector<double> x = average(map.x), y = average(map.y), z = average(map.z);
    const std::vector<double> r = average(albedo.r), g = average(albedo.g), b = average(albedo.b);
    for (std::size_t i = 0; i < x.size(); ++i) {
      level.lobes[0].emplace_back(glm::dvec4(x[i], y[i], z[i], 1.0));
      level.colours[0].emplace_back(glm::dvec3(r[i], g[i], b[i]));
    }
    mipmap.levels.push_back(std::move(level));
  }
  return mipmap;
}

std::vector<AccuracyRow> measure(MovmfMipmap mipmap, int first_level, const NormalMap& map, const ColourMap& albedo) {
  drop_finer_levels(mipmap, first_level);
  AccuracySettings settings;
  settings.samples_per_level = 0;
  return measure_accuracy(test_device(), mipmap, map, &albedo, settings, nullptr);
}

TEST(FirstLevelAccuracy, IsThatOfTheNormalMapsOwnLevels) {
  const NormalMap map = random_map(1, 0.6);
  const ColourMap albedo = random_colours(2, 1.0);
  const MovmfMipmap mipmap = average_lobes(map, albedo);
  const std::vector<AccuracyRow> whole = measure(mipmap, 0, map, albedo);
  for (const int first_level : {1, 2, 4}) {
    const std::vector<AccuracyRow> coarse = measure(mipmap, first_level, map, albedo);
    ASSERT_EQ(coarse.size(), whole.size());
    bool mixes = false;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      EXPECT_EQ(coarse[i].level, whole[i].level);
      EXPECT_EQ(coarse[i].sample_count, whole[i].sample_count);
      if (whole[i].level == first_level - 1 && whole[i].point == AccuracyPoint::kBetween) {
        // Mixing two shaded lobes differs from shading their mixture.
        mixes = mixes || std::abs(coarse[i].error - whole[i].error) > 1e-4;
      } else {
        EXPECT_NEAR(coarse[i].error, whole[i].error, 2e-6)
            << "level " << whole[i].level << " " << accuracy_point_name(whole[i].point) << " " << whole[i].brdf.text();
      }
    }
    EXPECT_TRUE(mixes);
  }
}

// If shading is linear in the mean vector and only colours vary, every mixture is exact. Any wrong weights would then
// change the error, also the weights between normal map and lobes.
TEST(FirstLevelAccuracy, LinearShadingIsExactAcrossTheTransition) {
  const NormalMap mild = random_map(3, 0.1);
  const ColourMap grey = random_colours(4, 0.0);
  const NormalMap flat = random_map(4, 0.0);
  const ColourMap colours = random_colours(5, 1.0);
  for (const int first_level : {0, 1, 2, 3}) {
    for (const AccuracyRow& row : measure(average_lobes(mild, grey), first_level, mild, grey))
      if (row.brdf.kind == AccuracyBrdfKind::kLambert) {
        EXPECT_LT(row.error, 3e-4) << first_level << ": level " << row.level << " " << accuracy_point_name(row.point);
      }
    for (const AccuracyRow& row : measure(average_lobes(flat, colours), first_level, flat, colours))
      EXPECT_LT(row.error, 3e-6) << first_level << ": level " << row.level << " " << accuracy_point_name(row.point)
                                 << " " << row.brdf.text();
  }
}

// If each texel is a single direction, shading it gives the BRDF itself.
TEST(AccuracyTest, IsTheRatioOfSums) {
  const NormalMap map = random_map(6, 0.5);
  MovmfMipmap mipmap = average_lobes(map, random_colours(7, 0.0));
  for (MovmfLevel& level : mipmap.levels) {
    level.colours.clear();
    for (glm::vec4& lobe : level.lobes[0]) lobe = glm::vec4(glm::normalize(glm::vec3(lobe)), 1.0f);
  }
  AccuracySettings settings;
  settings.samples_per_level = 0;
  settings.exponents = {4.0, 33.0};
  for (const AccuracyRow& row : measure_accuracy(test_device(), mipmap, map, settings, nullptr)) {
    if (row.point != AccuracyPoint::kCentre || row.brdf == AccuracyBrdf::lambert()) continue;
    const double s = row.brdf.exponent;
    const auto f = [&](double t) { return t > 0.0 ? (s + 1.0) / (2.0 * M_PI) * std::pow(t, s) : 0.0; };
    const MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(row.level)];
    double difference = 0.0, sum = 0.0;
    for (const glm::dvec3& h : accuracy_directions().half_vectors) {
      std::vector<double> finest;
      for (std::size_t i = 0; i < map.x.size(); ++i)
        finest.push_back(f(glm::dot(h, glm::dvec3(map.x[i], map.y[i], map.z[i]))));
      const std::vector<double> reference =
          average_over_texels(finest, {kWidth, kHeight}, {level.width, level.height}, 1);
      for (std::size_t i = 0; i < reference.size(); ++i) {
        difference += std::abs(f(glm::dot(h, glm::dvec3(level.lobes[0][i]))) - reference[i]);
        sum += reference[i];
      }
    }
    EXPECT_NEAR(row.error, difference / sum, 2e-5) << "level " << row.level << " " << row.brdf.text();
    EXPECT_EQ(row.sample_count, level.width * level.height);
    EXPECT_EQ(row.confidence, 0.0);
  }
}

void expect_same_rows(const std::vector<AccuracyRow>& found, const std::vector<AccuracyRow>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].level, expected[i].level);
    EXPECT_EQ(found[i].point, expected[i].point);
    EXPECT_EQ(found[i].brdf, expected[i].brdf);
    EXPECT_EQ(found[i].error, expected[i].error);
    EXPECT_EQ(found[i].confidence, expected[i].confidence);
    EXPECT_EQ(found[i].sample_count, expected[i].sample_count);
  }
}

MovmfLevel some_rows(const MovmfLevel& level, int first_row, int row_count) {
  MovmfLevel rows{level.width, row_count, {}, {}};
  const std::ptrdiff_t begin = std::ptrdiff_t{first_row} * level.width, end = begin + row_count * level.width;
  for (const auto& lobe : level.lobes) rows.lobes.emplace_back(lobe.begin() + begin, lobe.begin() + end);
  for (const auto& colour : level.colours) rows.colours.emplace_back(colour.begin() + begin, colour.begin() + end);
  return rows;
}

// Each highlight is scaled by its own integral. Diffuse light is the last value and is not scaled.
TEST(AccuracyTest, HighlightsAreScaledByTheirOwnTotals) {
  ShadingDirections directions{{glm::dvec3(0.0, 0.0, 1.0), glm::dvec3(0.6, 0.0, 0.8)}, {glm::dvec3(0.0, 0.0, 1.0)}, {}};
  for (const float total : {1.0f, 0.5f, 0.25f}) {
    directions.highlights.push_back(blinn_phong_highlight(10.0));
    directions.highlights.back().shaded.total = total;
  }
  std::vector<float> values(14, 1.0f);  // [value][point] of two points
  DirectionBuffers(test_device(), directions).scale_by_totals(values);
  const std::vector<float> of_point = {1.0f, 1.0f, 0.5f, 0.5f, 0.25f, 0.25f, 1.0f};
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], of_point[i / 2]) << i;
}

// The meter gets the rows from the last to the first, a few at a time, and only if it asks for them. Several thread
// counts are tested.
TEST(AccuracyTest, DoesNotDependOnHowRowsCome) {
  const NormalMap map = random_map(8, 0.6);
  const ColourMap albedo = random_colours(9, 1.0);
  const PlaneStore normals(kWidth, kHeight, {map.x.data(), map.y.data(), map.z.data()});
  const PlaneStore colours(kWidth, kHeight, {albedo.r.data(), albedo.g.data(), albedo.b.data()});
  for (const int first_level : {0, 2}) {
    MovmfMipmap mipmap = average_lobes(map, albedo);
    drop_finer_levels(mipmap, first_level);
    MovmfMipmap header = mipmap;
    for (MovmfLevel& level : header.levels) level.lobes = {{}};
    AccuracySettings settings;
    settings.samples_per_level = 6;
    // With footprints, a map this small would need all of its rows.
    settings.footprints_per_octave = first_level > 0 ? 4 : 0;
    settings.threads = 1;
    const std::vector<AccuracyRow> expected = measure_accuracy(test_device(), mipmap, map, &albedo, settings, nullptr);
    int unneeded_count = 0;
    for (const int threads : {2, 5}) {
      settings.threads = threads;
      MovmfMeter meter(header, true, settings);
      for (int l = first_level; l < static_cast<int>(mipmap.levels.size()); ++l) {
        const MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
        for (int end = level.height; end > 0; end -= threads) {
          const int first = std::max(0, end - threads);
          if (meter.needs_rows(l, first, end - first)) meter.add_rows(l, first, some_rows(level, first, end - first));
          else ++unneeded_count;
        }
      }
      expect_same_rows(meter.run(test_device(), normals, &colours, nullptr), expected);
    }
    EXPECT_TRUE(first_level > 0 || unneeded_count > 0);
  }
}

TEST(AccuracyTest, Cancels) {
  const NormalMap map = random_map(10, 0.3);
  Progress progress([](const ProgressEvent&) { return false; });
  EXPECT_THROW(measure_accuracy(test_device(), average_lobes(map, random_colours(11, 0.5)), map, {}, &progress),
               Cancelled);
}

}  // namespace
}  // namespace multum
