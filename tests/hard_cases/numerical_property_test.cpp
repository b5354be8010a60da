// SPDX-License-Identifier: Apache-2.0
// Tests properties of kernels on random inputs, which RapidCheck shrinks after a failure. The seed is fixed, so that
// every run is the same. RC_PARAMS="seed=N max_success=3000" in the environment sets another seed. A failure prints its
// seed.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/lab/reference/coverage.h"
#include "host/lab/reference/shading.h"
#include "host/lab/selftest/box_launch.h"
#include "host/lab/selftest/em_launch.h"
#include "host/lab/selftest/feature_launch.h"
#include "host/lab/selftest/moment_launch.h"
#include "host/lab/selftest/shade_launch.h"
#include "kernels/shared/movmf_fit.h"
#include "tests/fixtures/test_device.h"
#include "tests/hard_cases/random_values.h"

namespace multum {
namespace {

using testing::decades;
using testing::test_device;

// Generates directions on the whole sphere, often at the poles and on the equator.
rc::Gen<glm::dvec3> directions() {
  return rc::gen::map(rc::gen::pair(rc::gen::oneOf(rc::gen::inRange(0, 1801), rc::gen::element(0, 900, 1800)),
                                    rc::gen::inRange(0, 3600)),
                      [](const std::pair<int, int>& degrees) {
                        return glm::dvec3(glm::vec3(tilted(0.1 * degrees.first, 0.1 * degrees.second * M_PI / 180.0)));
                      });
}

EmTexel random_texel(int kappa_decades) {
  EmTexel texel;
  const auto count = *rc::gen::inRange<std::size_t>(1, 41);
  for (const glm::dvec3& n : *rc::gen::container<std::vector<glm::dvec3>>(count, directions()))
    texel.samples.push_back({n, *decades(-3, 3)});
  for (int j = 0; j < 3; ++j) texel.lobes.push_back({*directions(), *decades(-1, kappa_decades), *decades(-6, 0)});
  return texel;
}

// For any initial lobes, the shares sum to 1, no r is longer than 1, and the first moments equal the first moments of
// the normals.
RC_GTEST_PROP(EmProperty, MomentsAreKept, ()) {
  const EmTexel texel = random_texel(6);
  EmSettings settings;
  settings.iterations = *rc::gen::inRange(1, 9);
  glm::dvec4 mean(0.0);
  double weight = 0.0;
  for (const reference::Sample& s : texel.samples) {
    mean += s.weight * glm::dvec4(s.normal, 1.0);
    weight += s.weight;
  }
  for (const EmForm form : em_forms(test_device())) {
    const std::vector<FittedTexel> found = fit_texels(test_device(), {texel}, settings, form);
    glm::dvec4 sum(0.0);
    for (const glm::dvec4& lobe : found.front().lobes) {
      RC_ASSERT(lobe.w >= 0.0);
      RC_ASSERT(glm::length(glm::dvec3(lobe)) <= 1.0 + 2e-7);
      sum += lobe.w * glm::dvec4(glm::dvec3(lobe), 1.0);
    }
    RC_ASSERT(glm::length(sum - mean / weight) < 2e-5);
  }
}

// A single E-step does not amplify errors. At kappa 100, exponents have an error of 100 * 2.4e-7.
RC_GTEST_PROP(EmProperty, OneStepEqualsTheReference, ()) {
  const EmTexel texel = random_texel(2);
  EmSettings settings;
  settings.iterations = 1;
  WorstError worst;
  add_em_errors(test_device(), texel, settings, "random", worst);
  RC_ASSERT(worst.value() <= 5e-5);
}

// Compares with the formula in double precision, for any lobe, exponent and direction. Rounding (a r, a) to floats
// changes the spread by 1.2e-7.
RC_GTEST_PROP(ShadingProperty, EqualsItsFormula, ()) {
  const glm::dvec3 mu = *directions();
  const double spread = *rc::gen::oneOf(decades(-6, 0), rc::gen::element(0.0, 0.5, 1.0)), s = *decades(0, 5);
  const double amplitude = *rc::gen::element(1.0, 0.25, 1.0 / 1024.0);
  const glm::vec4 lobe(glm::dvec4(mu * (1.0 - spread), 1.0) * amplitude);
  const glm::vec4 h(glm::vec3(*directions()), 0.0f);
  // Also tests near the mean, where most of the light is.
  const glm::vec4 near(glm::vec3(glm::normalize(mu + 0.5 / std::sqrt(s) * glm::dvec3(h))), 0.0f);
  const double peak = reference::product_blinn_phong(s, spread, 0.0);
  for (const double value : shade_lobe(test_device(), lobe, static_cast<float>(s), {h, near}))
    RC_ASSERT(value >= 0.0 && value <= amplitude * peak * (1.0 + 6e-4 + 1e-6 * (s + 2.0)));
  const double theta = angle_seen(mu, near);
  RC_PRE(theta < 0.49 * M_PI);
  const double found = shade_lobe(test_device(), lobe, static_cast<float>(s), {near})[0] / amplitude;
  RC_ASSERT(std::abs(found - reference::product_blinn_phong(s, spread, theta)) <= peak * (6e-4 + 1e-6 * (s + 2.0)));
}

RC_GTEST_PROP(ShadingProperty, LambertIsBetweenNothingAndOne, ()) {
  const double r = *rc::gen::element(0.0, 1e-7, 0.3, 0.9, 0.999999, 1.0, 1.000001);
  const glm::vec4 lobe(glm::dvec4(*directions() * r, 1.0));
  for (const double value : shade_lobe(test_device(), lobe, 0.0f, {glm::vec4(glm::vec3(*directions()), 0.0f)}))
    RC_ASSERT(value >= -1e-6 && value <= 1.0 + 1e-6);
}

// The amplitudes of a stored texel sum to 1, and a lobe with a single direction keeps its length.
RC_GTEST_PROP(StorageProperty, SnormSumsToOneAndKeepsDirections, ()) {
  MovmfLevel level;
  level.width = level.height = 1;
  const auto count = *rc::gen::inRange<std::size_t>(1, 9);
  std::vector<double> shares;
  double total = 0.0;
  for (std::size_t j = 0; j < count; ++j) total += shares.emplace_back(*decades(-6, 0));
  for (const double share : shares)
    level.lobes.push_back({glm::vec4(glm::dvec4(*directions(), 1.0) * (share / total))});
  quantize_movmf(level, StorageEncoding::kSnorm16, 1);
  double steps = 0.0;
  for (const auto& lobe : level.lobes) {
    steps += std::round(static_cast<double>(lobe[0].w) * 32767.0);
    RC_ASSERT(glm::length(glm::dvec3(lobe[0])) >= static_cast<double>(lobe[0].w) * (1.0 - 1e-7));
  }
  RC_ASSERT(steps == 32767.0);
}

// Tests every block of a row of any width. The values have either sign and cover forty decades.
RC_GTEST_PROP(BoxProperty, BlocksAreSums, ()) {
  const RowBlocks blocks(*rc::gen::inRange(1, 400));
  std::vector<float> row(static_cast<std::size_t>(blocks.block_count(0)));
  for (float& x : row) x = static_cast<float>(*decades(-20, 20)) * *rc::gen::element(1.0f, -1.0f, 0.0f);
  const std::vector<float> nodes = block_sums(test_device(), blocks, {row}).front();
  for (int k = 0; k < blocks.depth(); ++k)
    for (int i = 0; i < blocks.block_count(k); ++i) {
      double sum = 0.0, magnitude = 0.0;
      for (int x = i << k; x < (i + 1) << k; ++x) {
        sum += static_cast<double>(row[static_cast<std::size_t>(x)]);
        magnitude += std::abs(static_cast<double>(row[static_cast<std::size_t>(x)]));
      }
      const double found = static_cast<double>(nodes[blocks.block_begin(k) + static_cast<std::size_t>(i)]);
      RC_ASSERT(std::abs(found - sum) <= k * 0x1p-23 * magnitude);
    }
}

// A normal of any direction and length gives slopes of at most 20 and a variance of at least 0. The normal itself does
// not change.
RC_GTEST_PROP(MomentProperty, SlopesHaveTheirBounds, ()) {
  const double length = *rc::gen::oneOf(decades(-30, 0), rc::gen::element(0.0, 0.5, 1.0, 1.0 + 0x1p-20));
  const bool shortened = *rc::gen::arbitrary<bool>();
  const glm::vec3 n(*directions() * length);
  const std::vector<float> m = finest_moments(test_device(), {n}, shortened).front();
  for (const int plane : {MULTUM_MOMENT_S, MULTUM_MOMENT_T}) {
    const double slope = static_cast<double>(m[static_cast<std::size_t>(plane)]);
    RC_ASSERT(std::abs(slope) <= 20.0 * (1.0 + 1e-6));
    const auto second = static_cast<std::size_t>(plane == MULTUM_MOMENT_S ? MULTUM_MOMENT_SS : MULTUM_MOMENT_TT);
    RC_ASSERT(static_cast<double>(m[second]) - slope * slope >= -1e-7 * slope * slope - 1e-30);
  }
  for (int k = 0; k < 3; ++k) RC_ASSERT(m[static_cast<std::size_t>(MULTUM_MOMENT_NORMAL + k)] == n[k]);
}

// For any moments (even impossible ones) and any half vector, the value is never below 0 or above the peak of the BRDF.
RC_GTEST_PROP(MomentProperty, LeanIsBetweenNothingAndItsPeak, ()) {
  const auto any = [](double low) {
    return static_cast<float>(*rc::gen::oneOf(decades(-6, 2), rc::gen::element(0.0, 1.0)) *
                              *rc::gen::element(low, 1.0));
  };
  MultumFilteredMoments m{};
  m.normal_z = m.share = 1.0f;
  m.s = any(-1.0), m.t = any(-1.0), m.ss = any(-1.0), m.tt = any(-1.0), m.st = any(-1.0);
  const double s = *decades(0, 5), peak = s / (2.0 * M_PI);
  const std::vector<double> values =
      shade_moments(test_device(), m, MULTUM_SHADE_LEAN, s, {glm::vec4(glm::vec3(*directions()), 0.0f)});
  RC_ASSERT(values[0] >= 0.0 && values[0] <= peak * (1.0 + 1e-5));
}

// For any lobes, sizes and chunks, the lobes of a texel together get all of its colours.
RC_GTEST_PROP(FeatureProperty, LobesShareOutAllColours, ()) {
  const EmTexel texel = random_texel(6);
  FeatureMap map{*rc::gen::inRange(1, 30), *rc::gen::inRange(1, 30), 1, 1, *rc::gen::inRange(1, 9), 1, {}, {}};
  map.level_width = std::max(1, map.width >> *rc::gen::inRange(1, 5));
  map.level_height = std::max(1, map.height >> *rc::gen::inRange(1, 5));
  RC_PRE(map.level_width * map.level_height <= MULTUM_GROUP);
  map.chunk_count = (map.height / map.level_height + 2) / map.chunk_rows + 2;
  for (int i = 0; i < map.width * map.height; ++i) {
    map.normals.push_back(glm::vec3(*directions()));
    map.values.push_back(glm::vec3(static_cast<float>(*decades(-3, 3)), 1.0f, 0.0f));
  }
  const auto found = feature_partials(test_device(), map, {texel});
  for (int t = 0; t < map.level_width * map.level_height; ++t) {
    glm::dvec3 sum(0.0), exact(0.0);
    for (const glm::vec3& part : found[static_cast<std::size_t>(t)]) sum += glm::dvec3(part);
    reference::for_each_covered(map.width, map.height, map.level_width, map.level_height, t % map.level_width,
                                t / map.level_width,
                                [&](std::size_t i, double weight) { exact += weight * glm::dvec3(map.values[i]); });
    for (int c = 0; c < 3; ++c) RC_ASSERT(std::abs(sum[c] - exact[c]) <= 1e-5 * exact[c]);
  }
}

}  // namespace
}  // namespace multum
