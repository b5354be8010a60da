// SPDX-License-Identifier: Apache-2.0
// Compares two implementations of the shading of planar Gaussians: the OpenCL code with which a bake measures its own
// error (kernels/device/gmm_shading.clh), and the GLSL code that renders (runtime_gl/shaders/common/gmm_shading.glsl).
// Both are also compared with double precision, first on hard cases, then on random lobes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/bakes/accuracy/highlight.h"
#include "host/formats/opencl/device.h"
#include "host/lab/reference/planar_em.h"
#include "runtime_gl/context/headless_context.h"
#include "tests/fixtures/random_values.h"
#include "tests/gl/shader_harness.h"

namespace multum {
namespace {

using testing::uniform24;

std::vector<glm::vec4> test_gaussians(unsigned seed) {
  std::vector<glm::vec4> lobes = {glm::vec4(0.0f), {1e-8f, 0.0f, 0.0f, 1e-8f}, {0.0f, 0.0f, 1e-40f, 1.0f}};
  const auto add = [&](double a, double mean, double azimuth, double variance) {
    const glm::dvec2 p = mean * glm::dvec2(std::cos(azimuth), std::sin(azimuth));
    lobes.push_back(glm::vec4(glm::dvec4(p.x, p.y, 2.0 * variance + glm::dot(p, p), 1.0) * a));
  };
  for (const double mean : {0.0, 0.3, 0.7, 0.99, 1.0, 1.0001})
    for (const double variance : {-1e-4, 0.0, 1e-5, 1e-3, 0.05, 0.4}) add(0.7, mean, 1.0, variance);
  std::mt19937 random(seed);
  for (int i = 0; i < 100; ++i)
    add(std::pow(10.0, -3.0 * uniform24(random)), uniform24(random), 6.28 * uniform24(random),
        0.4 * std::pow(10.0, -4.0 * uniform24(random)));
  return lobes;
}

std::vector<glm::vec3> directions_above(unsigned seed) {
  std::vector<glm::vec3> all = {{0.0f, 0.0f, 1.0f}, {0.6f, 0.0f, 0.8f}, {0.0f, -0.6f, 0.8f}, {0.99f, 0.0f, 0.1410674f}};
  std::mt19937 random(seed);
  for (int i = 0; i < 16; ++i) {
    const double z = 0.02 + 0.97 * uniform24(random), phi = 2.0 * M_PI * uniform24(random),
                 side = std::sqrt(1.0 - z * z);
    all.emplace_back(side * std::cos(phi), side * std::sin(phi), z);
  }
  return all;
}

// Returns values by [lobe][direction]. An exponent s of 0 selects Lambert's cosine.
std::vector<float> shade_gmm_opencl(const std::vector<glm::vec4>& lobes, const std::vector<glm::vec3>& directions,
                                    float s) {
  static Device device = Device::open("");
  std::vector<glm::vec4> vectors;
  for (const glm::vec3& d : directions) vectors.emplace_back(d, 0.0f);
  const DeviceBuffer in = device.wrap_buffer(lobes.data(), lobes.size() * sizeof(glm::vec4), "lobes");
  const DeviceBuffer around = device.wrap_buffer(vectors.data(), vectors.size() * sizeof(glm::vec4), "directions");
  const MultumHighlight shaded = shaded_highlight(static_cast<double>(s));
  const DeviceBuffer highlight = device.wrap_buffer(&shaded, sizeof(shaded), "highlight");
  std::vector<float> values(lobes.size() * directions.size(), NAN);
  const DeviceBuffer out = device.make_buffer(values.size() * sizeof(float), "values");
  const int count = static_cast<int>(directions.size());
  device.kernel("movmf_shade", "movmf_shade", {1, 1, false, true})
      .launch({lobes.size()}, in, around, around, highlight, out, static_cast<int>(lobes.size()), s > 0.0f ? count : 0,
              s > 0.0f ? 0 : count, s > 0.0f ? 1 : 0);
  device.read(out, values.data(), values.size() * sizeof(float));
  std::vector<float> by_lobe;  // the kernel writes [direction][lobe]
  for (std::size_t i = 0; i < lobes.size(); ++i)
    for (std::size_t d = 0; d < directions.size(); ++d) by_lobe.push_back(values[d * lobes.size() + i]);
  return by_lobe;
}

std::vector<float> shade_gmm_glsl(const gl::HeadlessContext& context, const std::vector<glm::vec4>& lobes,
                                  const std::vector<glm::vec3>& directions, float s) {
  gl::ShaderHarnessInput input{
      s > 0.0f ? "vec4(multum_gmm_density(a, b.xyz, b.w))" : "vec4(multum_gmm_lambert(a, b.xyz))", {}, {}, nullptr};
  for (const glm::vec4& lobe : lobes)
    for (const glm::vec3& d : directions) {
      input.a.push_back(lobe);
      input.b.emplace_back(d, s);
    }
  std::vector<float> values;
  for (const glm::vec4& value : gl::evaluate_shader(context.functions(), input)) values.push_back(value.x);
  return values;
}

double exact_value(const glm::dvec4& lobe, double s, const glm::dvec3& w) {
  return s > 0.0 ? reference::gmm_density(lobe, s, w) : reference::gmm_lambert(lobe, w);
}

// Returns the allowed error of single precision. Every operation rounds once, so this error is the change of the exact
// value when each number of the lobe and of the direction changes by kRoundings float roundings. The variance is a
// difference of numbers up to the amplitude a, so its rounding error is relative to a. The z of the Lambert term is the
// root of such a difference. The exponential adds 1e-5 of the value. Results that underflow are negligible compared
// with a peak. The measured error is a tenth of what kRoundings = 8 allows.
double tolerance(const glm::dvec4& lobe, double s, const glm::dvec3& w) {
  constexpr double kRoundings = 8.0, kStep = kRoundings * 0x1p-24;
  const double value = exact_value(lobe, s, w);
  double sum = 1e-5 * value + 1e-30 * (s + 1.0);
  const auto add = [&](const glm::dvec4& lobe_step, const glm::dvec3& step) {
    sum += std::max(std::abs(exact_value(lobe + lobe_step, s, w + step) - value),
                    std::abs(exact_value(lobe - lobe_step, s, w - step) - value));
  };
  for (int c = 0; c < 4; ++c) {
    glm::dvec4 step(0.0);
    step[c] = kStep * (c == 2 ? std::max(lobe.z, lobe.w) : std::abs(lobe[c]));
    add(step, glm::dvec3(0.0));
  }
  for (int c = 0; c < 3; ++c) {
    glm::dvec3 step(0.0);
    step[c] = kStep * std::abs(w[c]);
    add(glm::dvec4(0.0), step);
  }
  return sum;
}

class GmmAgreementTest : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Exponents, GmmAgreementTest, ::testing::Values(0.0, 1.0, 20.0, 100.0, 500.0, 1e4),
                         [](const ::testing::TestParamInfo<double>& exponent) {
                           return "S" + std::to_string(static_cast<int>(exponent.param));
                         });

TEST_P(GmmAgreementTest, OpenclGlslAndDoubleAgree) {
  constexpr unsigned kSeed = 2005;
  const double s = GetParam();
  const std::vector<glm::vec4> lobes = test_gaussians(kSeed);
  const std::vector<glm::vec3> directions = directions_above(kSeed);
  const auto context = gl::make_headless_context(gl::ContextBackend::kOsmesa);
  const std::vector<float> opencl = shade_gmm_opencl(lobes, directions, static_cast<float>(s));
  const std::vector<float> glsl = shade_gmm_glsl(*context, lobes, directions, static_cast<float>(s));
  int seen = 0, tight = 0;  // counts of values that matter, and of values with a tolerance below 1 %
  for (std::size_t i = 0; i < lobes.size(); ++i) {
    const glm::dvec4 lobe(lobes[i]);
    const bool is_seen = lobes[i].w > 1e-6f;
    for (std::size_t d = 0; d < directions.size(); ++d) {
      const glm::dvec3 w(directions[d]);
      // Where the amplitude is almost 0, both results are 0.
      const double expected = is_seen ? exact_value(lobe, s, w) : 0.0, bound = is_seen ? tolerance(lobe, s, w) : 0.0;
      seen += expected > 1e-6 * lobe.w * (s + 1.0) ? 1 : 0;
      tight += expected > 1e-6 * lobe.w * (s + 1.0) && bound < 0.01 * expected ? 1 : 0;
      EXPECT_NEAR(static_cast<double>(opencl[i * directions.size() + d]), expected, bound) << i << ", " << d;
      EXPECT_NEAR(static_cast<double>(glsl[i * directions.size() + d]), expected, bound) << i << ", " << d;
    }
  }
  EXPECT_GT(seen, 250);
  EXPECT_GT(tight, 0.95 * seen) << "the bounds are too wide to be useful";
}

// Tests how much energy the edge of the plane cuts off: integrates the facets of one normal over the hemisphere
// (docs/contributing/ALGORITHMS.md). A model that loses no energy would give 1.
TEST(GmmEnergy, IsLostTowardsTheRim) {
  constexpr int kRings = 400, kSpokes = 360;
  const double exponents[] = {5.0, 20.0, 100.0, 500.0};
  const std::map<int, std::array<double, 4>> stated = {{0, {0.98, 1.00, 1.00, 1.00}},
                                                       {30, {0.90, 0.99, 1.00, 1.00}},
                                                       {45, {0.78, 0.94, 1.00, 1.00}},
                                                       {60, {0.63, 0.77, 0.95, 1.00}},
                                                       {75, {0.50, 0.56, 0.67, 0.85}}};
  for (const auto& [tilt, energies] : stated)
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = std::sin(tilt * std::numbers::pi / 180.0);
      double sum = 0.0;
      for (int ring = 0; ring < kRings; ++ring)  // rings of equal width on the plane: d omega = r dr dphi / h_z
        for (int spoke = 0; spoke < kSpokes; ++spoke) {
          const double r = (ring + 0.5) / kRings, phi = 2.0 * std::numbers::pi * (spoke + 0.5) / kSpokes;
          const glm::dvec3 h(r * std::cos(phi), r * std::sin(phi), std::sqrt(1.0 - r * r));
          sum += reference::gmm_density({x, 0.0, x * x, 1.0}, exponents[i], h) / h.z * r;
        }
      EXPECT_NEAR(sum / kRings * 2.0 * std::numbers::pi / kSpokes, energies[i], 0.006)
          << tilt << " degrees, s " << exponents[i];
    }
}

}  // namespace
}  // namespace multum
