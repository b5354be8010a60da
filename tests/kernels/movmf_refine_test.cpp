// SPDX-License-Identifier: Apache-2.0
// movmf_refine against the double reference on random texels and hard ones; the scalar against the vector variant, bit
// for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include <glm/geometric.hpp>

#include "host/opencl/launch_shape.h"
#include "host/reference/movmf_refine.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/movmf_refine.h"
#include "kernels/shared/vmf_lobe.h"
#include "tests/reference/test_device.h"

namespace multum::testing {
namespace {

constexpr std::size_t kLanes = MULTUM_GROUP;

// Samples and lobes as floats hold them.
struct RefinedTexel {
  std::vector<reference::Sample> samples;
  std::vector<reference::MeanLobe> lobes;
};

double as_float(double value) { return static_cast<double>(static_cast<float>(value)); }
glm::dvec3 as_float(const glm::dvec3& v) { return {as_float(v.x), as_float(v.y), as_float(v.z)}; }

// Facets with some roughness, and lobes near them that a fit might have left.
RefinedTexel random_texel(std::size_t sample_count, std::size_t lobe_count, std::mt19937& random) {
  const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24 * 2.0 - 1.0; };
  std::vector<glm::dvec3> facets;
  for (std::size_t j = 0; j < lobe_count; ++j) facets.push_back(glm::normalize(glm::dvec3(uniform(), uniform(), 1.0)));
  RefinedTexel texel;
  for (std::size_t i = 0; i < sample_count; ++i) {
    const double x = uniform(), y = uniform(), z = uniform();
    texel.samples.push_back({as_float(glm::normalize(facets[random() % lobe_count] + 0.2 * glm::dvec3(x, y, z))),
                             as_float(1.0 + 0.5 * uniform())});
  }
  double total = 0.0;
  for (const glm::dvec3& facet : facets) {
    const double x = uniform(), y = uniform(), length = 0.97 + 0.02 * uniform();
    texel.lobes.push_back(
        {as_float(length * glm::normalize(facet + 0.05 * glm::dvec3(x, y, 0.0))), 1.0 + 0.5 * uniform()});
    total += texel.lobes.back().amplitude;
  }
  for (reference::MeanLobe& lobe : texel.lobes) lobe.amplitude = as_float(lobe.amplitude / total);
  return texel;
}

double weight_of(const RefinedTexel& texel) {
  double total = 0.0;
  for (const reference::Sample& sample : texel.samples) total += sample.weight;
  return total;
}

// The kernel on one texel in lane 3 of a group whose other slots are unused; [lobe][lane].
std::vector<MultumVmfLobe> run_kernel(const RefinedTexel& texel, int vector_width) {
  Device& device = test_device();
  const std::size_t count = texel.samples.size(), lobe_count = texel.lobes.size(), lane = 3;
  std::vector<float> samples(count * 4 * kLanes);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t l = 0; l < kLanes; ++l) {
      const reference::Sample& s = texel.samples[i];
      const double values[4] = {s.normal.x, s.normal.y, s.normal.z, s.weight};
      for (std::size_t k = 0; k < 4; ++k) samples[(i * 4 + k) * kLanes + l] = static_cast<float>(values[k]);
    }
  const std::vector<int> counts = {static_cast<int>(count)};
  std::vector<int> list(kLanes, -1);
  list[lane] = static_cast<int>(lane);
  // Poison: what no texel of the list owns must stay.
  std::vector<MultumVmfLobe> level(lobe_count * kLanes, MultumVmfLobe{7.0f, 7.0f, 7.0f, 7.0f});
  for (std::size_t j = 0; j < lobe_count; ++j) {
    const reference::MeanLobe& lobe = texel.lobes[j];
    level[j * kLanes + lane] = {static_cast<float>(lobe.r.x), static_cast<float>(lobe.r.y),
                                static_cast<float>(lobe.r.z), static_cast<float>(lobe.amplitude)};
  }
  MultumMovmfFit fit = {};
  fit.map_width = fit.width = MULTUM_GROUP;
  fit.map_height = fit.height = fit.window_rows = fit.map_window_rows = 1;
  fit.slot_count = MULTUM_GROUP;
  fit.sample_capacity = static_cast<int>(count);
  fit.total_weight_inverse = static_cast<float>(1.0 / weight_of(texel));
  const DeviceBuffer sample_buffer = device.wrap_buffer(samples.data(), samples.size() * sizeof(float), "samples");
  const DeviceBuffer count_buffer = device.wrap_buffer(counts.data(), sizeof(int), "sample counts");
  const DeviceBuffer list_buffer = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  DeviceBuffer level_buffer = device.make_buffer(level.size() * sizeof(MultumVmfLobe), "lobes");
  device.write(level_buffer, level.data(), level.size() * sizeof(MultumVmfLobe));
  device.kernel("movmf_refine", "movmf_refine", {static_cast<int>(lobe_count), vector_width, true})
      .launch({kLanes / static_cast<std::size_t>(vector_width)}, sample_buffer, count_buffer, list_buffer, level_buffer,
              fit);
  device.read(level_buffer, level.data(), level.size() * sizeof(MultumVmfLobe));
  std::vector<MultumVmfLobe> found;
  for (std::size_t j = 0; j < lobe_count; ++j)
    for (std::size_t l = 0; l < kLanes; ++l) {
      const MultumVmfLobe& lobe = level[j * kLanes + l];
      if (l == lane) found.push_back(lobe);
      else EXPECT_TRUE(lobe.mean_x == 7.0f && lobe.amplitude == 7.0f) << "slot " << l;
    }
  return found;
}

// Both variants, which give the same bytes.
std::vector<MultumVmfLobe> refined_by_kernel(const RefinedTexel& texel) {
  const std::vector<MultumVmfLobe> scalar = run_kernel(texel, 1), vector = run_kernel(texel, 16);
  EXPECT_EQ(0, std::memcmp(scalar.data(), vector.data(), scalar.size() * sizeof(MultumVmfLobe)));
  return scalar;
}

// The largest |a - a'| and |a r - a' r'| of a texel's lobes.
double difference(const std::vector<MultumVmfLobe>& found, const std::vector<reference::MeanLobe>& expected) {
  double most = 0.0;
  for (std::size_t j = 0; j < found.size(); ++j) {
    const double a = static_cast<double>(found[j].amplitude);
    const glm::dvec3 r(found[j].mean_x, found[j].mean_y, found[j].mean_z);
    const double off =
        std::max(std::abs(a - expected[j].amplitude), glm::length(a * r - expected[j].amplitude * expected[j].r));
    most = std::isnan(off) ? HUGE_VAL : std::max(most, off);
  }
  return most;
}

// A step in fp32 errs by some 1e-6 (sums of up to 300 samples) and 3e-5 of kappa (kappa_of_mean_length), 6 damped steps
// add these up: below 1e-4 here, 5e-4 is asserted.
TEST(MovmfRefineTest, EqualsReference) {
  constexpr unsigned kSeed = 20271;
  std::mt19937 random(kSeed);
  SCOPED_TRACE(kSeed);
  for (const std::size_t lobe_count : {std::size_t{4}, std::size_t{6}})
    for (int i = 0; i < 4; ++i) {
      const RefinedTexel texel = random_texel(5 + random() % 300, lobe_count, random);
      const auto expected = reference::refine(texel.samples, texel.lobes, MULTUM_REFINE_STEPS);
      EXPECT_LT(difference(refined_by_kernel(texel), expected), 5e-4) << lobe_count << " lobes";
    }
}

// What it is for: highlights come nearer, and the mean normal stays that of the samples.
TEST(MovmfRefineTest, ComesNearerAndKeepsTheMeanNormal) {
  std::mt19937 random(31);
  for (int i = 0; i < 8; ++i) {
    const RefinedTexel texel = random_texel(64, 4, random);
    const auto refined = reference::refine(texel.samples, texel.lobes, MULTUM_REFINE_STEPS);
    EXPECT_LT(reference::refined_energy(texel.samples, refined), reference::refined_energy(texel.samples, texel.lobes));
    glm::dvec3 off(0.0);
    double amplitude = 0.0;
    for (const MultumVmfLobe& lobe : refined_by_kernel(texel)) {
      off += static_cast<double>(lobe.amplitude) * glm::dvec3(lobe.mean_x, lobe.mean_y, lobe.mean_z);
      amplitude += static_cast<double>(lobe.amplitude);
    }
    for (const reference::Sample& sample : texel.samples) off -= sample.weight / weight_of(texel) * sample.normal;
    EXPECT_LT(glm::length(off), 2e-3);  // exact but for lobes that would be longer than 1
    EXPECT_NEAR(amplitude, 1.0, 1e-6);
  }
}

// All normals equal, lobes alike, a lobe without weight or without a direction, one normal, normals on the equator.
TEST(MovmfRefineTest, HardCases) {
  const glm::dvec3 up(0.0, 0.0, 1.0), tilted = as_float(glm::normalize(glm::dvec3(0.6, 0.1, 0.8)));
  const std::vector<RefinedTexel> texels = {
      {std::vector<reference::Sample>(64, {tilted, 1.0}), {{tilted, 0.5}, {tilted, 0.5}}},
      {{{up, 1.0}, {tilted, 1.0}, {up, 2.0}}, {{0.9 * up, 0.5}, {0.9 * up, 0.5}}},
      {{{up, 1.0}, {tilted, 1.0}}, {{0.9 * up, 1.0}, {0.5 * tilted, 0.0}}},
      {{{{1.0, 0.0, 0.0}, 1.0}, {{-1.0, 0.0, 0.0}, 1.0}}, {{{0.0, 0.0, 0.0}, 0.5}, {{0.0, 0.0, 0.0}, 0.5}}},
      {{{up, 1.0}}, {{up, 0.5}, {0.3 * tilted, 0.5}}},
      {{{{0.0, 1.0, 0.0}, 1.0}, {{0.0, -1.0, 0.0}, 3.0}}, {{{0.0, 0.9, 0.0}, 0.25}, {{0.0, -0.9, 0.0}, 0.75}}}};
  for (std::size_t i = 0; i < texels.size(); ++i) {
    RefinedTexel texel = texels[i];
    for (reference::MeanLobe& lobe : texel.lobes) lobe.r = as_float(lobe.r);
    const std::vector<MultumVmfLobe> found = refined_by_kernel(texel);
    EXPECT_LT(difference(found, reference::refine(texel.samples, texel.lobes, MULTUM_REFINE_STEPS)), 2e-3) << i;
    for (const MultumVmfLobe& lobe : found) {
      EXPECT_GE(lobe.amplitude, 0.0f) << i;
      EXPECT_LE(glm::length(glm::dvec3(lobe.mean_x, lobe.mean_y, lobe.mean_z)), 1.0 + 1e-6) << i;
    }
  }
}

}  // namespace
}  // namespace multum::testing
