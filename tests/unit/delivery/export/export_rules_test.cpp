// SPDX-License-Identifier: Apache-2.0
// Compares the engines' rules for roughness with numbers that are derived from the engines' sources. Also tests the
// signs of axes, the samples of facets, and the effect of rounding.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include <glm/geometric.hpp>

#include "host/delivery/export/accuracy/export_rules.h"
#include "host/delivery/export/axis_cut.h"
#include "host/delivery/export/facet_samples.h"
#include "host/delivery/export/material_folder.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::make_map;

double perceptual(const GgxLobe& lobe) { return std::sqrt(lobe.alpha_wide); }

const EngineRule& rule_called(const std::string& id) {
  for (const EngineRule& rule : engine_rules())
    if (rule.id == id) return rule;
  throw std::runtime_error("no rule " + id);
}

// The expected results for a base roughness of 0.1 and a kappa of 50 are computed by hand from the formula of each
// rule.
TEST(ExportRules, AreThoseOfTheirSources) {
  double low = 0.9, high = 0.999999;
  for (int i = 0; i < 60; ++i) (kappa_of_length(0.5 * (low + high)) < 50.0 ? low : high) = 0.5 * (low + high);
  const std::map<std::string, double> expected = {
      {"averaged", 0.1}, {"unreal", 0.4461}, {"unity", 0.3170}, {"godot", 0.1581}, {"filament", 0.2236}};
  ASSERT_EQ(engine_rules().size(), expected.size());
  for (const auto& [id, roughness] : expected)
    EXPECT_NEAR(perceptual(lobe_of_rule(rule_called(id), {glm::dvec3(0.0, 0.0, low), 0.1})), roughness, 1e-3) << id;
}

TEST(ExportRules, KeepTheRoughnessOfOneNormal) {
  for (const EngineRule& rule : engine_rules())
    for (const double roughness : {0.05, 0.1, 0.5, 1.0}) {
      const GgxLobe lobe = lobe_of_rule(rule, {glm::dvec3(0.6, 0.0, 0.8), roughness});
      EXPECT_NEAR(perceptual(lobe), roughness, 1e-4) << rule.id;
      EXPECT_NEAR(glm::distance(lobe.normal, glm::dvec3(0.6, 0.0, 0.8)), 0.0, 1e-12) << rule.id;
    }
}

TEST(ExportRules, GrowWithTheSpreadAndEndAt1) {
  for (const EngineRule& rule : engine_rules()) {
    double before = 0.0;
    for (double length = 1.0; length > 0.01; length -= 0.01) {
      const double roughness = perceptual(lobe_of_rule(rule, {glm::dvec3(0.0, 0.0, length), 0.3}));
      EXPECT_GE(roughness, before - 1e-12) << rule.id << ", " << length;
      EXPECT_LE(roughness, 1.0) << rule.id << ", " << length;
      before = roughness;
    }
  }
}

// Half of GGX's facets have slopes below alpha, and a fifth below half of alpha. Every square of samples that covers
// one texel of the finest level has these shares, in all directions.
TEST(FacetSamples, AreSpreadInEverySquare) {
  for (const int grid : {8, 16, 32}) {
    const std::vector<glm::vec2> facets = facet_samples(grid);
    for (const int side : {4, 8, grid})
      for (int y = 0; y < grid; y += side)
        for (int x = 0; x < grid; x += side) {
          int within_one = 0, within_half = 0, quadrants[4] = {};
          for (int j = y; j < y + side; ++j)
            for (int i = x; i < x + side; ++i) {
              const glm::vec2 slope = facets[static_cast<std::size_t>(j * grid + i)];
              within_one += glm::length(slope) < 1.0f;
              within_half += glm::length(slope) < 0.5f;
              ++quadrants[(slope.x > 0.0f ? 1 : 0) + (slope.y > 0.0f ? 2 : 0)];
            }
          EXPECT_NEAR(within_one, 0.5 * side * side, 0.04 * side * side) << grid << ", " << side;
          EXPECT_NEAR(within_half, 0.2 * side * side, 0.08 * side * side) << grid << ", " << side;
          for (const int count : quadrants) EXPECT_EQ(count, side * side / 4) << grid << ", " << side;
        }
  }
}

// The sides of each level are exactly half of the previous sides, so every texel of the finest level has the same
// number of samples.
TEST(FacetSamples, PlacesAreEvenWhereLevelsNest) {
  for (const int level : {1, 2, 3, 5}) {
    const int grid = sample_grid(level), coarse = 4, fine = coarse << level;
    std::map<int, int> counts;
    for (int x = 0; x < coarse; ++x)
      for (int i = 0; i < grid; ++i) ++counts[sample_place(x, i, grid, coarse, fine)];
    EXPECT_EQ(static_cast<int>(counts.size()), fine);
    for (const auto& [place, count] : counts) EXPECT_EQ(count, grid * coarse / fine) << level << ", " << place;
  }
  EXPECT_EQ(sample_place(0, 0, 8, 1, 3), 0);
  EXPECT_EQ(sample_place(0, 7, 8, 1, 3), 2);
}

// In slightly crooked grooves at any angle, the signs make all axes point to the same side.
TEST(AxisCut, LeavesBrushedMetalInOnePiece) {
  for (double degrees = 0.0; degrees < 180.0; degrees += 15.0) {
    const double angle = degrees * M_PI / 180.0;
    const NormalMap map = make_map(64, 64, [&](int x, int y) {
      const double tilt = 0.3 * std::sin(7.0 * (x * std::cos(angle) + y * std::sin(angle)) + 0.1 * x * y);
      const double turned = angle + 0.2 * std::sin(0.37 * x + 0.51 * y);
      return glm::normalize(glm::dvec3(tilt * std::cos(turned), tilt * std::sin(turned), 1.0));
    });
    const double cut = find_axis_cut(planes_of(map));
    for (const double off : {-0.4, 0.0, 0.4})
      for (const double sign : {-1.0, 1.0}) {
        const glm::vec2 axis(sign * std::cos(angle + off), sign * std::sin(angle + off));
        const glm::vec2 middle(std::cos(angle), std::sin(angle));
        EXPECT_GT(glm::dot(signed_axis(axis, cut), signed_axis(middle, cut)), 0.0f) << degrees << ", " << off;
      }
  }
}

TEST(AxisCut, IsThereWithoutAnyAxis) {
  const NormalMap flat = make_map(16, 16, [](int, int) { return glm::dvec3(0.0, 0.0, 1.0); });
  EXPECT_GT(signed_axis({1.0f, 0.0f}, find_axis_cut(planes_of(flat))).x *
                signed_axis({-1.0f, 0.0f}, find_axis_cut(planes_of(flat))).x,
            0.0f);
  const NormalMap one = make_map(1, 1, [](int, int) { return glm::dvec3(0.0, 0.0, 1.0); });
  EXPECT_TRUE(std::isfinite(find_axis_cut(planes_of(one))));
}

TEST(RoundedMaterial, StaysAsItIs) {
  for (const MaterialTexels texels : {MaterialTexels::kRgba8, MaterialTexels::kRgba16f, MaterialTexels::kRg8}) {
    MaterialRows rows{2, 2, {}, {}, {}, {}, {}};
    for (const float i : {0.0f, 1.0f, 2.0f, 3.0f}) {
      rows.normals.push_back(glm::normalize(glm::vec3(0.3f * i - 0.4f, 0.17f * i, 1.0f)));
      rows.roughness.push_back(0.123f * i);
      rows.anisotropy.emplace_back(0.6f, -0.8f, 0.07f * i);
      rows.metalness.push_back(0.3f * i);
    }
    MaterialRows once = rows;
    round_material(once, texels);
    MaterialRows twice = once;
    round_material(twice, texels);
    const float step = texels == MaterialTexels::kRgba16f ? 1.0f / 2048.0f : 1.0f / 255.0f;
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(once.normals[i], twice.normals[i]);
      EXPECT_EQ(once.anisotropy[i], twice.anisotropy[i]);
      EXPECT_EQ(once.roughness[i], twice.roughness[i]);
      EXPECT_EQ(once.metalness[i], twice.metalness[i]);
      EXPECT_NEAR(once.roughness[i], rows.roughness[i], 0.51f * step);
      EXPECT_LE(glm::distance(once.normals[i], rows.normals[i]), 1.8f * step);
    }
    EXPECT_NE(once.roughness[1], rows.roughness[1]);
    EXPECT_TRUE(once.occlusion.empty());
  }
}

}  // namespace
}  // namespace multum
