// SPDX-License-Identifier: Apache-2.0
// Compares facet distributions, environments, and the light from environments that lobes reflect with closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/vmf_terms.h"
#include "host/formats/light/environment_light.h"
#include "host/formats/light/reflection_table.h"

namespace multum {
namespace {

Brdf brdf_of(BrdfKind kind) {
  Brdf brdf;
  brdf.kind = kind;
  return brdf;
}

template <typename Radiance>
EnvironmentMap make_map(int height, const Radiance& radiance) {
  EnvironmentMap map{2 * height, height, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < 2 * height; ++x)
      map.texels.emplace_back(radiance(environment_direction((x + 0.5) / (2 * height), (y + 0.5) / height)));
  return map;
}

// The coefficients of (s + 1) / (2 pi) t^s are a_0 = 1, a_1 = (s + 1) / (s + 2) and
// a_l = a_(l-2) (s - l + 2) / (s + l + 1).
TEST(FacetDistribution, ZonalCoefficientsOfBlinnPhongAreThoseOfItsRecurrence) {
  for (const float s : {1.0f, 12.0f, 100.0f, 1e5f}) {
    Brdf brdf;
    brdf.exponent = s;
    const std::vector<glm::dvec3> a = zonal_coefficients(brdf, 12);
    std::vector<double> exact = {1.0, (static_cast<double>(s) + 1.0) / (static_cast<double>(s) + 2.0)};
    for (int l = 2; l <= 12; ++l)
      exact.push_back(exact[static_cast<std::size_t>(l - 2)] * (static_cast<double>(s) - l + 2.0) /
                      (static_cast<double>(s) + l + 1.0));
    for (std::size_t l = 0; l < exact.size(); ++l) EXPECT_NEAR(a[l].y, exact[l], 1e-9) << "s " << s << " l " << l;
  }
}

TEST(FacetDistribution, OfGgxProjectsToOne) {
  for (const float roughness : {0.05f, 0.3f, 0.7f, 1.0f}) {
    Brdf brdf = brdf_of(BrdfKind::kGgx);
    brdf.roughness = roughness;
    const glm::dvec3 projected =
        integrate_zonal([&](double e) { return facet_density(brdf, e) * std::max(1.0 - e, 0.0); });
    EXPECT_NEAR(projected.x, 1.0, 1e-6) << roughness;
  }
}

TEST(VmfTerms, OneIsTheVmfItself) {
  const auto vmf = [](double e) { return glm::dvec3(50.0 / (2.0 * std::numbers::pi) * std::exp(-50.0 * e)); };
  const std::vector<VmfTerm> terms = fit_vmf_terms(vmf, 1);
  EXPECT_NEAR(terms[0].kappa, 50.0, 0.05);
  EXPECT_NEAR(terms[0].weight.x, 1.0, 1e-3);
  EXPECT_NEAR(terms[0].spread, 0.02, 1e-4);
}

TEST(VmfTerms, ChannelsShareTheirKappas) {
  const auto two = [](double e) {
    const double narrow = 400.0 * std::exp(-400.0 * e), broad = 10.0 * std::exp(-10.0 * e);
    return glm::dvec3(narrow + broad, narrow, broad);
  };
  const std::vector<VmfTerm> terms = fit_vmf_terms(two, 2);
  EXPECT_NEAR(terms[0].kappa, 400.0, 8.0);
  EXPECT_NEAR(terms[1].kappa, 10.0, 0.3);
  EXPECT_NEAR(terms[0].weight.y, 2.0 * std::numbers::pi, 0.1);
  EXPECT_NEAR(terms[1].weight.z, 2.0 * std::numbers::pi, 0.1);
  EXPECT_LT(terms[1].weight.y, 0.1);
  EXPECT_LT(terms[0].weight.z, 0.1);
}

// A sheen is 0 at the normal and brightest near the horizon. Broad terms of both signs approximate it.
TEST(VmfTerms, FitADensityThatHasNoPeak) {
  for (const double power : {0.5, 1.0, 1.4}) {
    const auto sheen = [&](double e) { return glm::dvec3(e < 1.0 ? std::pow(e * (2.0 - e), power) : 0.0); };
    const std::vector<VmfTerm> terms = fit_vmf_terms(sheen, 4);
    const auto off = [&](double e) {
      double sum = 0.0;
      for (const VmfTerm& term : terms)
        sum += term.weight.x * term.kappa / (-2.0 * std::numbers::pi * std::expm1(-2.0 * term.kappa)) *
               std::exp(-term.kappa * e);
      return glm::dvec3(e < 1.0 ? std::abs(std::max(sum, 0.0) - sheen(e).x) : 0.0);
    };
    EXPECT_LT(integrate_zonal(off).x / integrate_zonal(sheen).x, 0.085) << power;
  }
}

TEST(Environment, DirectionsAndCoordinatesAreInverse) {
  for (const double s : {0.01, 0.3, 0.5, 0.99})
    for (const double t : {0.02, 0.5, 0.9}) {
      const glm::dvec2 st = environment_coordinates(environment_direction(s, t));
      EXPECT_NEAR(st.x, s, 1e-12);
      EXPECT_NEAR(st.y, t, 1e-12);
    }
  EXPECT_NEAR(environment_direction(0.5, 0.5).z, -1.0, 1e-12);
  EXPECT_NEAR(environment_direction(0.75, 0.5).x, 1.0, 1e-12);
}

TEST(Environment, ShrinkingKeepsTheLight) {
  const EnvironmentMap map = make_map(24, [](const glm::dvec3& d) { return glm::vec3(glm::abs(d)); });
  for (const int width : {48, 20, 16}) {
    const EnvironmentMap small = shrink(map, width);
    EXPECT_LE(small.width, width);
    EXPECT_NEAR(smooth_environment(small).mean[1], smooth_environment(map).mean[1], 0.01) << width;
  }
}

TEST(Harmonics, AreOrthonormal) {
  constexpr int kOrder = 8;
  std::vector<std::vector<double>> products((kOrder + 1) * (kOrder + 1),
                                            std::vector<double>((kOrder + 1) * (kOrder + 1)));
  constexpr int kHeight = 96;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < 2 * kHeight; ++x) {
      const glm::dvec3 d = environment_direction((x + 0.5) / (2 * kHeight), (y + 0.5) / kHeight);
      const std::vector<double> values = harmonics(d, kOrder);
      const double weight = texel_solid_angle(2 * kHeight, kHeight, y);
      for (std::size_t i = 0; i < values.size(); ++i)
        for (std::size_t j = 0; j <= i; ++j) products[i][j] += weight * values[i] * values[j];
    }
  for (std::size_t i = 0; i < products.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) EXPECT_NEAR(products[i][j], i == j ? 1.0 : 0.0, 5e-3) << i << " " << j;
}

TEST(SmoothEnvironment, IsThePolynomialThatMadeTheMap) {
  const SmoothEnvironment smooth = smooth_environment(
      make_map(64, [](const glm::dvec3& d) { return glm::vec3(2.0 + d.y, 1.0 + 0.5 * d.x * d.z, 3.0); }));
  EXPECT_NEAR(smooth.mean[0], 2.0, 1e-3);
  EXPECT_NEAR(smooth.linear[0].y, 1.0, 2e-3);
  EXPECT_NEAR(smooth.linear[0].x, 0.0, 1e-6);
  EXPECT_NEAR(smooth.quadratic[1][0][2], 0.25, 1e-3);
  EXPECT_NEAR(smooth.quadratic[2][1][1], 0.0, 1e-2);
}

// Filtering 1 + cos with a vMF scales the cosine by the vMF's mean cosine, which is 1 minus the level's spread.
TEST(PrefilteredLevels, HaveTheirMeanCosines) {
  const PrefilteredLevels result =
      prefilter(make_map(64, [](const glm::dvec3& d) { return glm::vec3(1.0 + d.y, 1.0, 0.0); }));
  ASSERT_EQ(result.levels.size(), 5u);  // 64 to 4 rows
  for (std::size_t k = 0; k < result.levels.size(); ++k) {
    const SmoothEnvironment smooth = smooth_environment(result.levels[k]);
    EXPECT_NEAR(smooth.linear[0].y, 1.0 - result.spreads[k], 0.02) << k;
    EXPECT_NEAR(smooth.mean[1], 1.0, 1e-5);
    if (k > 0) {
      EXPECT_GT(result.spreads[k], result.spreads[k - 1]);
    }
  }
}

// With light of 1 from every direction, L' = 4 (v.h)^2 on a hemisphere has the mean 4 (2 pi / 3) Y_00. A mix of two
// prepared environments equals the prepared mix of both, except for rounding to floats.
TEST(EnvironmentLight, MixingIsLinear) {
  const auto sky = [](const glm::dvec3& d) { return glm::vec3(1.0 + d.y, 0.5, 0.2 * d.x * d.x); };
  const auto lamp = [](const glm::dvec3& d) { return glm::vec3(d.z > 0.9 ? 40.0f : 0.1f); };
  constexpr double kShare = 0.3;
  const auto a = make_environment_light(make_map(32, sky)), b = make_environment_light(make_map(32, lamp));
  const auto anew = make_environment_light(make_map(32, [&](const glm::dvec3& d) {
    return static_cast<float>(1.0 - kShare) * sky(d) + static_cast<float>(kShare) * lamp(d);
  }));
  const auto mixed = mix_environments(a, b, kShare);
  ASSERT_EQ(mixed->levels.levels.size(), anew->levels.levels.size());
  EXPECT_EQ(mixed->levels.spreads, anew->levels.spreads);
  const auto expect_same = [](const EnvironmentMap& found, const EnvironmentMap& expected) {
    ASSERT_EQ(found.texels.size(), expected.texels.size());
    for (std::size_t i = 0; i < found.texels.size(); ++i)
      ASSERT_LT(glm::length(found.texels[i] - expected.texels[i]), 1e-5f * (1.0f + glm::length(expected.texels[i])));
  };
  expect_same(mixed->map, anew->map);
  expect_same(mixed->small, anew->small);
  for (std::size_t l = 0; l < anew->levels.levels.size(); ++l)
    expect_same(mixed->levels.levels[l], anew->levels.levels[l]);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(mixed->smooth.mean[c], anew->smooth.mean[c], 1e-5);
    EXPECT_LT(glm::length(mixed->smooth.linear[c] - anew->smooth.linear[c]), 1e-5);
    for (int row = 0; row < 3; ++row)
      EXPECT_LT(glm::length(mixed->smooth.quadratic[c][row] - anew->smooth.quadratic[c][row]), 1e-5);
  }
  EXPECT_NEAR(mixed->sampler.total(), anew->sampler.total(), 1e-5 * anew->sampler.total());
  EXPECT_LT(glm::length(mixed->sampler.direction(3) - anew->sampler.direction(3)), 0.1);
  EXPECT_EQ(mix_environments(a, b, 0.0), a);
  EXPECT_EQ(mix_environments(a, b, 1.0), b);
}

TEST(HalfVectorLight, OfConstantLight) {
  const EnvironmentMap white = make_map(64, [](const glm::dvec3&) { return glm::vec3(1.0f); });
  for (const glm::dvec3 v : {glm::dvec3(0.0, 1.0, 0.0), glm::normalize(glm::dvec3(1.0, -0.3, 0.4))}) {
    const std::vector<glm::dvec3> light = half_vector_light(white, v);
    EXPECT_NEAR(light[0].x, 8.0 * std::numbers::pi / 3.0 * std::sqrt(0.25 / std::numbers::pi), 5e-3);
    // For l = 1, 4 times the integral of c^3 over the hemisphere is 2 pi, along v.
    const double along = std::sqrt(0.75 / std::numbers::pi) * 2.0 * std::numbers::pi;
    EXPECT_NEAR(light[3].x, along * v.x, 0.02);
    EXPECT_NEAR(light[2].x, along * v.z, 0.02);
    EXPECT_NEAR(light[1].x, along * v.y, 0.02);
  }
}

const ReflectionEntry& entry_at(const std::vector<ReflectionEntry>& table, int row, double cosine) {
  return table[static_cast<std::size_t>(row * kReflectionCosineCount +
                                        std::lround((0.5 + 0.5 * cosine) * (kReflectionCosineCount - 1)))];
}

TEST(ReflectionTable, OfAMirrorIsTheWeightOfItsDirection) {
  Brdf brdf;
  brdf.exponent = 1e4f;
  const auto tables = reflection_tables(brdf);
  ASSERT_EQ(tables.size(), 1u);
  for (const double at : {0.3, 0.6, 1.0}) {
    const ReflectionEntry& entry = entry_at(tables[0], 0, at);
    const double c = 2.0 * static_cast<double>(std::lround((0.5 + 0.5 * at) * (kReflectionCosineCount - 1))) /
                         (kReflectionCosineCount - 1) -
                     1.0;
    EXPECT_NEAR(entry.weight.x, 4.0 * c * c, 0.02);
    EXPECT_NEAR(entry.plain, 4.0 * c * c, 0.02);
  }
}

// White facets do not absorb light, and smooth facets do not cast shadows. Hence all light is reflected.
TEST(ReflectionTable, SmoothGgxReflectsEverything) {
  Brdf brdf = brdf_of(BrdfKind::kGgx);
  brdf.roughness = 0.3f;
  brdf.f0 = glm::vec3(1.0f);
  const auto tables = reflection_tables(brdf);
  ASSERT_EQ(tables.size(), 4u);
  for (const double cosine : {0.4, 0.7, 1.0}) {
    double sum = 0.0;
    for (const auto& table : tables) sum += entry_at(table, 0, cosine).weight.x;
    EXPECT_NEAR(sum, 1.0, 0.05) << cosine;
  }
}

}  // namespace
}  // namespace multum
