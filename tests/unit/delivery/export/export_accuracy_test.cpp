// SPDX-License-Identifier: Apache-2.0
// Tests how the error of an export is measured. Compares the sampled lights with plain quadrature, and tests the
// results for exact and wrong lobes and the search for the best lobe.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "host/delivery/export/accuracy/cell_reference.h"
#include "host/delivery/export/accuracy/export_accuracy.h"
#include "host/delivery/export/accuracy/lobe_optimum.h"
#include "host/foundation/base/error.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::make_map;
using testing::random_map;

CoveredFacets facets_of(const NormalMap& map, double alpha) {
  return covered_facets(planes_of(map), nullptr, alpha * alpha, 1, 1, 0, 0);
}

// Returns D V (n . l) as the papers print it, with the G2 of Smith's Lambda functions.
double printed_highlight(const GgxLobe& lobe, const glm::dvec3& v, const glm::dvec3& l) {
  const glm::dvec3 b = glm::cross(lobe.normal, lobe.axis), h = glm::normalize(v + l);
  const auto local = [&](const glm::dvec3& w) {
    return glm::dvec3(glm::dot(w, lobe.axis), glm::dot(w, b), glm::dot(w, lobe.normal));
  };
  const glm::dvec3 lv = local(v), ll = local(l), lh = local(h);
  if (lv.z <= 0.0 || ll.z <= 0.0) return 0.0;
  const double at = lobe.alpha_wide, ab = lobe.alpha_narrow;
  const auto lambda = [&](const glm::dvec3& w) {
    return 0.5 * (std::sqrt(1.0 + (at * at * w.x * w.x + ab * ab * w.y * w.y) / (w.z * w.z)) - 1.0);
  };
  const double e = lh.x * lh.x / (at * at) + lh.y * lh.y / (ab * ab) + lh.z * lh.z;
  const double d = 1.0 / (M_PI * at * ab * e * e), g = 1.0 / (1.0 + lambda(lv) + lambda(ll));
  return d * g / (4.0 * lv.z * ll.z) * ll.z;
}

GgxLobe some_lobe(double wide, double narrow) {
  GgxLobe lobe = GgxLobe::isotropic(glm::normalize(glm::dvec3(0.3, -0.2, 1.0)), wide);
  lobe.alpha_narrow = narrow;
  lobe.axis = glm::normalize(lobe.axis + 0.7 * glm::cross(lobe.normal, lobe.axis));
  return lobe;
}

LightSet grid_of_lights(const glm::dvec3& view, int side) {
  LightSet set;
  set.view = view;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const double z = (j + 0.5) / side, phi = 2.0 * M_PI * (i + 0.5) / side, s = std::sqrt(1.0 - z * z);
      set.add({s * std::cos(phi), s * std::sin(phi), z});
    }
  return set;
}

TEST(LobeShading, IsThePrintedFormula) {
  const glm::dvec3 view = glm::normalize(glm::dvec3(0.4, 0.5, 0.6));
  const LightSet set = grid_of_lights(view, 24);
  for (const GgxLobe& lobe : {some_lobe(0.3, 0.3), some_lobe(0.5, 0.1), some_lobe(1.0, 0.05)}) {
    std::vector<double> values, sums(set.size()), densities(set.size());
    highlights(set, lobe, values);
    add_highlights(set, lobe.normal, lobe.alpha_wide * lobe.alpha_wide, 2.0, sums.data(), densities.data());
    for (std::size_t i = 0; i < set.size(); ++i) {
      const double expected = printed_highlight(lobe, view, {set.x[i], set.y[i], set.z[i]});
      EXPECT_NEAR(values[i], expected, 1e-9 * (1.0 + expected)) << i;
      if (lobe.alpha_wide != lobe.alpha_narrow) continue;
      EXPECT_NEAR(sums[i], 2.0 * expected, 1e-9 * (1.0 + expected)) << i;
    }
  }
}

// Compares sampled lights with even quadrature over the upper hemisphere. The allowed difference is four times the
// noise of the lights.
TEST(CellReference, LightsIntegrateWhatQuadratureDoes) {
  for (const double alpha : {0.1, 0.5}) {
    const CoveredFacets facets = facets_of(random_map(4, 4, 0.8, 5), alpha);
    const ReferenceLights lights = point_lights(facets, 2000, 7);
    double expected = 0.0;
    for (const LightSet& sampled : lights.views) {
      const LightSet grid = grid_of_lights(sampled.view, 700);
      std::vector<double> values(grid.size()), densities(grid.size());
      for (std::size_t i = 0; i < facets.normals.size(); ++i)
        add_highlights(grid, facets.normals[i], facets.alpha_squared[i], facets.weights[i], values.data(),
                       densities.data());
      for (const double value : values) expected += value * 2.0 * M_PI / static_cast<double>(grid.size());
    }
    EXPECT_NEAR(lights.total / expected, 1.0, 4.0 * lights.noise + 0.002) << alpha;
    EXPECT_LT(lights.noise, 0.02);
  }
}

TEST(CellReference, ExactLobesHaveNoError) {
  const NormalMap map = make_map(8, 8, [](int, int) { return glm::normalize(glm::dvec3(0.2, 0.1, 1.0)); });
  const CoveredFacets facets = facets_of(map, 0.2);
  EXPECT_NEAR(glm::length(facets.mean_normal), 1.0, 1e-6);
  EXPECT_NEAR(facets.mean_roughness, std::sqrt(0.2), 1e-6);
  const GgxLobe exact = GgxLobe::isotropic(glm::normalize(facets.mean_normal), 0.2),
                wider = GgxLobe::isotropic(exact.normal, 0.4);
  const ReferenceLights points = point_lights(facets, 200, 1), wide = wide_lights(facets, 60, 1);
  EXPECT_LT(error_of_lobe(points, exact).error, 1e-5);
  EXPECT_NEAR(error_of_lobe(points, exact).energy, 1.0, 1e-5);
  EXPECT_LT(error_of_lobe(wide, exact, kWideLightPoints).error, 1e-5);
  EXPECT_GT(error_of_lobe(points, wider).error, 0.4);
  // A wide light hides the differences between lobes.
  EXPECT_LT(error_of_lobe(wide, wider, kWideLightPoints).error, error_of_lobe(points, wider).error);
}

// With odd sides, the weight of a finest texel is the fraction of it that is covered.
TEST(CellReference, CoversFractions) {
  const NormalMap map = make_map(3, 5, [](int x, int y) { return glm::normalize(glm::dvec3(0.1 * x, 0.1 * y, 1.0)); });
  const CoveredFacets facets = covered_facets(planes_of(map), nullptr, 0.04, 1, 2, 0, 1);
  ASSERT_EQ(facets.normals.size(), 9u);
  EXPECT_NEAR(facets.weights[0], 0.5 / 7.5, 1e-12);
  EXPECT_NEAR(facets.weights[8], 1.0 / 7.5, 1e-12);
}

TEST(LobeOptimum, IsNoWorseThanItsStartAndFindsALobe) {
  const CoveredFacets facets = facets_of(random_map(8, 8, 0.9, 3), 0.2);
  const ReferenceLights lights = point_lights(facets, 150, 9);
  const auto value = [&](const GgxLobe& lobe) {
    const LobeError found = error_of_lobe(lights, lobe);
    return found.error + std::abs(found.energy - 1.0);
  };
  const GgxLobe start = GgxLobe::isotropic(glm::normalize(facets.mean_normal), 0.2);
  const GgxLobe round = find_lobe_optimum(lights, start, false, 1e-3),
                any = find_lobe_optimum(lights, start, true, 1e-3);
  EXPECT_LT(value(round), 0.8 * value(start));
  EXPECT_LE(value(any), value(round) + 0.02);
  EXPECT_EQ(round.alpha_wide, round.alpha_narrow);
  // If one lobe is the exact answer, the search finds it.
  const NormalMap one = make_map(4, 4, [](int, int) { return glm::normalize(glm::dvec3(0.2, 0.1, 1.0)); });
  const ReferenceLights of_one = point_lights(facets_of(one, 0.3), 150, 9);
  const GgxLobe off = GgxLobe::isotropic(glm::normalize(glm::dvec3(0.25, 0.05, 1.0)), 0.2);
  const GgxLobe found = find_lobe_optimum(of_one, off, false, 1e-3);
  EXPECT_NEAR(found.alpha_wide, 0.3, 0.01);
  EXPECT_LT(error_of_lobe(of_one, found).error, 0.03);
}

TEST(ExportMeter, MeasuresWhatItIsShown) {
  const NormalMap map = random_map(64, 64, 0.9, 11);
  const PlaneStore normals = planes_of(map);
  ExportAccuracySettings measuring;
  measuring.cells_per_level = 4;
  measuring.lights_per_view = 60;
  OneLobeInputs inputs;
  inputs.normals = &normals;
  inputs.threads = 2;
  OneLobeSettings settings;
  settings.base_roughness = 0.4;
  const auto measured = [&](double roughness) {
    ExportMeter meter(64, 64, measuring);
    for (int level = 0; level < 7; ++level) {
      const int side = 64 >> level;
      MaterialRows rows{side, side, {}, {}, {}, {}, {}};
      rows.normals.assign(static_cast<std::size_t>(side * side), {0.0f, 0.0f, 1.0f});
      rows.roughness.assign(rows.normals.size(), static_cast<float>(roughness));
      meter.add_level(level, 0, rows);
    }
    return meter.run(inputs, settings, nullptr);
  };
  const ExportAccuracy base = measured(0.4), wide = measured(0.55);
  ASSERT_EQ(base.levels.size(), 3u);  // 2, 4, 6
  EXPECT_EQ(base.cells.size(), 4u + 4u + 1u);
  EXPECT_EQ(base.ids[0], "export");
  for (std::size_t l = 0; l < 3; ++l) {
    // At level 6 the mean normal is nearly upright, and averaged normals have only the base roughness.
    EXPECT_LT(wide.levels[l].errors[0].point.error, base.levels[l].errors[0].point.error);
    // These rules read only the map.
    EXPECT_EQ(wide.levels[l].errors[2].point.error, base.levels[l].errors[2].point.error);
  }
  EXPECT_NEAR(base.levels[2].errors[0].point.error, base.levels[2].errors[1].point.error, 0.05);
  EXPECT_NE(base.to_text().find("Unreal"), std::string::npos);
  int events = 0;
  Progress cancels([&](const ProgressEvent&) { return ++events < 2; });
  ExportMeter meter(64, 64, measuring);
  EXPECT_THROW(meter.run(inputs, settings, &cancels), Cancelled);
}

}  // namespace
}  // namespace multum
