// SPDX-License-Identifier: Apache-2.0
// Tests what a bake keeps if a map is mirrored, rotated by 90 degrees or tiled twice, as
// docs/contributing/ALGORITHMS.md promises in "Reasons for the file format". The lobes may change, and their difference
// is measured and printed.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <glm/geometric.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/averages/moment_bake.h"
#include "host/bakes/averages/sh_bake.h"
#include "host/bakes/movmf/movmf_bake.h"
#include "host/formats/testmap/four_quarter_map.h"
#include "tests/fixtures/test_device.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::test_device;

// Describes a rearranged map. Its texel (x, y) is the texel at place(x, y, size) of the map or of a level with that
// size, with rotated vectors. Row numbers increase downwards, whereas y of normals points up.
struct Layout {
  const char* name;
  std::function<PlaneSize(PlaneSize)> size;
  std::function<std::pair<int, int>(int x, int y, PlaneSize)> place;
  std::function<glm::dvec3(const glm::dvec3&)> turned;
};

const std::vector<Layout>& layouts() {
  const auto same_size = [](PlaneSize s) { return s; };
  const auto as_is = [](const glm::dvec3& v) { return v; };
  static const std::vector<Layout> all = {
      {"mirrored in x", same_size, [](int x, int y, PlaneSize s) { return std::pair(s.width - 1 - x, y); },
       [](const glm::dvec3& v) { return glm::dvec3(-v.x, v.y, v.z); }},
      {"mirrored in y", same_size, [](int x, int y, PlaneSize s) { return std::pair(x, s.height - 1 - y); },
       [](const glm::dvec3& v) { return glm::dvec3(v.x, -v.y, v.z); }},
      {"turned by 90 degrees",
       [](PlaneSize s) {
         return PlaneSize{s.height, s.width};
       },
       [](int x, int y, PlaneSize s) { return std::pair(y, s.height - 1 - x); },
       [](const glm::dvec3& v) { return glm::dvec3(v.y, -v.x, v.z); }},
      {"tiled twice",
       [](PlaneSize s) {
         return PlaneSize{2 * s.width, s.height};
       },
       [](int x, int y, PlaneSize s) { return std::pair(x % s.width, y); }, as_is},
  };
  return all;
}

bool is_tiled(const Layout& layout) { return layout.size({1, 1}).width == 2; }

std::size_t index_at(const Layout& layout, int x, int y, PlaneSize original) {
  const auto [from_x, from_y] = layout.place(x, y, original);
  return static_cast<std::size_t>(from_y) * static_cast<std::size_t>(original.width) + static_cast<std::size_t>(from_x);
}

NormalMap laid_out(const Layout& layout, const NormalMap& map) {
  const PlaneSize original{map.width, map.height}, size = layout.size(original);
  return testing::make_map(size.width, size.height, [&](int x, int y) {
    const std::size_t i = index_at(layout, x, y, original);
    return layout.turned(glm::dvec3(map.x[i], map.y[i], map.z[i]));
  });
}

MovmfMipmap bake(const NormalMap& map, bool periodic = false) {
  MovmfSettings settings;
  settings.periodic_x = settings.periodic_y = periodic;
  FitReport report;
  return bake_movmf(test_device(), map, nullptr, settings, report, nullptr);
}

MovmfMipmap as_decoded(MovmfMipmap mipmap) {
  quantize_movmf(mipmap, 2);
  return mipmap;
}

// Returns two sums over a texel's lobes: the sum of a r, which is the mean normal, and the sum of a, which is the
// energy.
glm::dvec4 lobe_sum(const MovmfLevel& level, std::size_t texel) {
  glm::dvec4 sum(0.0);
  for (const auto& lobe : level.lobes) sum += glm::dvec4(lobe[texel]);
  return sum;
}

// Holds the largest difference, over the levels that both pyramids have, between properties that do not depend on the
// layout, or (from level 1 up) between lobes.
struct Differences {
  double finest = 0.0, mean = 0.0, energy = 0.0, lobes = 0.0;
};

Differences compare(const Layout& layout, const MovmfMipmap& original, const MovmfMipmap& other) {
  Differences found;
  for (std::size_t l = 0; l < original.levels.size(); ++l) {
    const MovmfLevel &a = original.levels[l], &b = other.levels[l];
    const PlaneSize size = layout.size({a.width, a.height});
    EXPECT_EQ(b.width, size.width);
    EXPECT_EQ(b.height, size.height);
    for (int y = 0; y < b.height; ++y)
      for (int x = 0; x < b.width; ++x) {
        const std::size_t i = index_at(layout, x, y, {a.width, a.height});
        const std::size_t k =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(b.width) + static_cast<std::size_t>(x);
        const glm::dvec4 u = lobe_sum(a, i), v = lobe_sum(b, k);
        const double off = glm::length(layout.turned(glm::dvec3(u)) - glm::dvec3(v));
        found.mean = std::max(found.mean, off);
        if (l == 0) found.finest = std::max(found.finest, off);
        found.energy = std::max({found.energy, std::abs(u.w - 1.0), std::abs(v.w - 1.0)});
        for (std::size_t j = 0; l > 0 && j < a.lobes.size(); ++j)
          found.lobes =
              std::max(found.lobes, glm::length(layout.turned(glm::dvec3(a.lobes[j][i])) - glm::dvec3(b.lobes[j][k])));
      }
  }
  return found;
}

// Rearranges lights and half vectors in the same way as the map, so that the references are the same and only the model
// differs.
AccuracySettings settings_for(const Layout& layout) {
  AccuracySettings settings;
  settings.samples_per_level = 0;
  for (auto* vectors : {&settings.directions.lights, &settings.directions.half_vectors})
    for (glm::dvec3& v : *vectors) v = layout.turned(v);
  return settings;
}

// Holds the differences between errors at texel centres, for the levels that both pyramids have.
struct ErrorDifference {
  double most = 0.0;           // the largest absolute difference
  double most_of_error = 0.0;  // the largest relative difference where the error is above 1 %
  double mean = 0.0;           // the relative difference between the means over levels and BRDFs
};

ErrorDifference error_difference(const std::vector<AccuracyRow>& a, const std::vector<AccuracyRow>& b) {
  ErrorDifference found;
  double sum_a = 0.0, sum_b = 0.0;
  for (const AccuracyRow& row : a) {
    if (row.point != AccuracyPoint::kCentre) continue;
    const auto same = std::find_if(b.begin(), b.end(), [&](const AccuracyRow& other) {
      return other.level == row.level && other.point == row.point && other.brdf == row.brdf;
    });
    if (same == b.end()) {
      ADD_FAILURE() << "no level " << row.level;
      continue;
    }
    const double difference = std::abs(row.error - same->error);
    found.most = std::max(found.most, difference);
    if (row.error > 0.01) found.most_of_error = std::max(found.most_of_error, difference / row.error);
    sum_a += row.error;
    sum_b += same->error;
  }
  found.mean = std::abs(sum_b / sum_a - 1.0);
  return found;
}

struct SymmetryCase {
  const char* name;
  NormalMap map;
  bool halves;  // each level has half of the previous level's size, so tiles always consist of whole texels
};

std::vector<SymmetryCase> cases() {
  return {{"four quarters 64 x 64", make_four_quarter_map(64, 3).normals, true},
          {"noise 64 x 16", testing::random_map(64, 16, 0.3, 7), true},
          {"noise 50 x 37", testing::random_map(50, 37, 0.3, 8), false}};
}

class SymmetryTest : public ::testing::TestWithParam<int> {
 protected:
  const Layout& layout() const { return layouts()[static_cast<std::size_t>(GetParam())]; }
};
INSTANTIATE_TEST_SUITE_P(Layouts, SymmetryTest, ::testing::Range(0, 4));

// snorm16 rounds a value by up to half a step of 1/32767, so sums of four lobes differ by up to four steps per channel.
constexpr double kStep = 1.0 / 32767.0;
constexpr double kMeanSteps = 4.0 * 1.7321;
// Up to 4096 floats are added in another order. The bound is three times the difference that was measured on these
// maps.
constexpr double kFloatMean = 2e-6;

TEST_P(SymmetryTest, MeanNormalsAndEnergyStay) {
  for (const auto& [name, map, halves] : cases()) {
    if (is_tiled(layout()) && !halves) continue;  // the texels of the two pyramids cover different areas
    for (const bool periodic : {false, true}) {
      if (periodic && !halves) continue;
      const MovmfMipmap original = bake(map, periodic), other = bake(laid_out(layout(), map), periodic);
      const Differences floats = compare(layout(), original, other),
                        stored = compare(layout(), as_decoded(original), as_decoded(other));
      std::printf(
          "%-22s %-20s%s in floats: mean normals %.1e, energy %.1e; as stored, steps of 1/32767: level 0 %.2f, mean "
          "normals %.2f, energy %.2f; lobes %.0f\n",
          name, layout().name, periodic ? " periodic" : "         ", floats.mean, floats.energy, stored.finest / kStep,
          stored.mean / kStep, stored.energy / kStep, stored.lobes / kStep);
      EXPECT_EQ(stored.finest, 0.0) << name;
      EXPECT_LT(floats.mean, kFloatMean) << name;
      EXPECT_LT(floats.energy, kFloatMean) << name;
      EXPECT_LT(stored.mean, kMeanSteps * kStep) << name;
      EXPECT_LT(stored.energy, 1e-6) << name << ": whole steps sum to 1, k/32767 as floats to 5e-8";
    }
  }
}

// These are bounds on how much the errors change; docs/contributing/ALGORITHMS.md also states them. The error of a
// single level changes by at most 45 % here, and the mean error by at most 3.2 %. The 45 % occur on noise of 64 x 16
// texels, where each normal of level 1 belongs entirely to one lobe or to another.
constexpr double kErrorsDiffer = 0.6, kMeansDiffer = 0.05;

TEST_P(SymmetryTest, LobesDifferAndErrorsLittle) {
  for (const auto& [name, map, halves] : cases()) {
    if (is_tiled(layout()) && !halves) continue;
    const NormalMap other = laid_out(layout(), map);
    const MovmfMipmap a = as_decoded(bake(map, false)), b = as_decoded(bake(other, false));
    const auto plain = measure_accuracy(test_device(), a, map, settings_for(layouts().back()), nullptr);
    const auto turned = measure_accuracy(test_device(), b, other, settings_for(layout()), nullptr);
    const auto fixed = measure_accuracy(test_device(), b, other, settings_for(layouts().back()), nullptr);
    const ErrorDifference moved = error_difference(plain, turned), under_fixed = error_difference(plain, fixed);
    std::printf(
        "%-22s %-20s errors differ by at most %.2f percentage points, %.1f %% of the error, means by %.1f %%; under "
        "unchanged lights by %.2f percentage points, %.0f %%, %.0f %%\n",
        name, layout().name, 100.0 * moved.most, 100.0 * moved.most_of_error, 100.0 * moved.mean,
        100.0 * under_fixed.most, 100.0 * under_fixed.most_of_error, 100.0 * under_fixed.mean);
    EXPECT_GT(compare(layout(), a, b).lobes, 30.0 * kStep) << name << ": update docs/contributing/ALGORITHMS.md";
    EXPECT_LT(moved.most_of_error, kErrorsDiffer) << name;
    EXPECT_LT(moved.mean, kMeansDiffer) << name;
  }
}

// Averages do not prefer a direction. Except for rounding, the moments and harmonics of the rearranged map have the
// same errors.
TEST_P(SymmetryTest, AveragesErrAlike) {
  for (const auto& [name, map, halves] : cases()) {
    if (is_tiled(layout()) && !halves) continue;
    const NormalMap other = laid_out(layout(), map);
    const auto moments = [&](const NormalMap& normals, const Layout& turned) {
      AverageReport report;
      const MomentMipmap baked = bake_moments(test_device(), normals, nullptr, {}, report, nullptr);
      return measure_accuracy(test_device(), baked, normals, nullptr, settings_for(turned), nullptr);
    };
    const auto harmonics = [&](const NormalMap& normals, const Layout& turned) {
      AverageReport report;
      const ShMipmap baked = bake_sh(test_device(), 4, normals, nullptr, {}, report, nullptr);
      return measure_accuracy(test_device(), baked, normals, nullptr, settings_for(turned), nullptr);
    };
    const double of_moments = error_difference(moments(map, layouts().back()), moments(other, layout())).most;
    const double of_harmonics = error_difference(harmonics(map, layouts().back()), harmonics(other, layout())).most;
    std::printf("%-22s %-20s errors differ by %.1e (moments), %.1e (harmonics)\n", name, layout().name, of_moments,
                of_harmonics);
    EXPECT_LT(of_moments, 1e-5) << name;
    EXPECT_LT(of_harmonics, 1e-5) << name;
  }
}

}  // namespace
}  // namespace multum
