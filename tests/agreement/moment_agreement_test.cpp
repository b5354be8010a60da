// SPDX-License-Identifier: Apache-2.0
// The shading of moments in OpenCL (kernels/device/moment_shading.clh, by which a bake measures its own error) and in
// GLSL (runtime_gl/shaders/common/moment_shading.glsl, by which it is rendered), and both against double precision:
// hard cases first, then random moments.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "host/opencl/device.h"
#include "host/reference/moments.h"
#include "kernels/shared/moments.h"
#include "runtime_gl/context/headless_context.h"
#include "tests/gl/shader_harness.h"

namespace multum {
namespace {

double uniform(std::mt19937& random) { return static_cast<double>(random() >> 8) * 0x1p-24; }

// Moments as floats have them, with a mean normal of any length.
MultumFilteredMoments moments(double s, double t, double deviation_s, double deviation_t, double correlation,
                              double length) {
  MultumFilteredMoments m{};
  const glm::dvec3 n = length * glm::normalize(glm::dvec3(-s, -t, 1.0));
  m.normal_x = static_cast<float>(n.x);
  m.normal_y = static_cast<float>(n.y);
  m.normal_z = static_cast<float>(n.z);
  m.share = 1.0f;
  m.s = static_cast<float>(s);
  m.t = static_cast<float>(t);
  m.ss = static_cast<float>(deviation_s * deviation_s + s * s);
  m.tt = static_cast<float>(deviation_t * deviation_t + t * t);
  m.st = static_cast<float>(correlation * deviation_s * deviation_t + s * t);
  return m;
}

std::vector<MultumFilteredMoments> test_moments(unsigned seed) {
  std::vector<MultumFilteredMoments> all;
  for (const double slope : {0.0, 0.3, -1.0, 3.0})
    for (const double deviation : {0.0, 1e-3, 0.05, 0.5, 3.0})
      for (const double correlation : {-1.0, 0.0, 0.9})
        all.push_back(moments(slope, -0.5 * slope, deviation, 0.5 * deviation, correlation, 0.95));
  for (const double length : {1e-6, 0.1, 0.5, 0.9999, 1.0, 1.0005})
    all.push_back(moments(0.4, 0.2, 0.1, 0.1, 0.0, length));
  MultumFilteredMoments rounded = moments(0.7, -0.7, 0.0, 0.0, 0.0, 1.0);
  rounded.ss *= 0.9995f;  // as rounding to halfs may leave it: less than the square of the mean
  rounded.st *= 1.0005f;
  all.push_back(rounded);
  std::mt19937 random(seed);
  for (int i = 0; i < 200; ++i)
    all.push_back(moments(2.0 * uniform(random) - 1.0, 2.0 * uniform(random) - 1.0,
                          std::pow(10.0, -3.0 * uniform(random)), std::pow(10.0, -3.0 * uniform(random)),
                          1.9 * uniform(random) - 0.95, uniform(random)));
  return all;
}

std::vector<glm::vec3> test_half_vectors(unsigned seed) {
  std::vector<glm::vec3> all = {{0.0f, 0.0f, 1.0f}, {0.6f, 0.0f, 0.8f}, {0.0f, -0.6f, 0.8f}, {0.99f, 0.0f, 0.1410674f}};
  std::mt19937 random(seed);
  for (int i = 0; i < 20; ++i) {
    const double z = 0.05 + 0.95 * uniform(random), phi = 2.0 * M_PI * uniform(random), side = std::sqrt(1.0 - z * z);
    all.emplace_back(glm::normalize(glm::vec3(glm::dvec3(side * std::cos(phi), side * std::sin(phi), z))));
  }
  return all;
}

// [moments][half vector]
std::vector<float> shade_opencl(const std::vector<MultumFilteredMoments>& set,
                                const std::vector<glm::vec3>& half_vectors, float exponent, int shading) {
  static Device device = Device::open("");
  std::vector<glm::vec4> vectors;
  for (const glm::vec3& h : half_vectors) vectors.emplace_back(h, 0.0f);
  const DeviceBuffer in = device.wrap_buffer(set.data(), set.size() * sizeof(MultumFilteredMoments), "moments");
  const DeviceBuffer directions = device.wrap_buffer(vectors.data(), vectors.size() * sizeof(glm::vec4), "directions");
  const DeviceBuffer exponents = device.wrap_buffer(&exponent, sizeof(float), "exponent");
  std::vector<float> values(set.size() * half_vectors.size(), NAN);
  const DeviceBuffer out = device.make_buffer(values.size() * sizeof(float), "values");
  device.kernel("moment_shade", "moment_shade", {1, 1, false})
      .launch({set.size()}, in, directions, directions, exponents, out, static_cast<int>(set.size()),
              static_cast<int>(half_vectors.size()), 0, 1, shading);
  device.read(out, values.data(), values.size() * sizeof(float));
  return values;
}

std::vector<float> shade_glsl(const gl::HeadlessContext& context, const std::vector<MultumFilteredMoments>& set,
                              const std::vector<glm::vec3>& half_vectors, float exponent, int shading) {
  // A half vector of the upper half is its x and y.
  const std::string h = "vec3(b.xy, sqrt(max(1.0 - dot(b.xy, b.xy), 0.0)))";
  gl::ShaderHarnessInput input{shading == MULTUM_SHADE_TOKSVIG
                                   ? "vec4(multum_moments_toksvig(a.xyz, " + h + ", b.w))"
                                   : "vec4(multum_moments_lean(a, b.z, " + h + ", b.w, " +
                                         (shading == MULTUM_SHADE_LEAN_JACOBIAN ? "true" : "false") + "))",
                               {},
                               {},
                               nullptr};
  for (const MultumFilteredMoments& m : set)
    for (const glm::vec3& half_vector : half_vectors) {
      if (shading == MULTUM_SHADE_TOKSVIG) input.a.emplace_back(m.normal_x, m.normal_y, m.normal_z, 0.0f);
      else input.a.emplace_back(m.s, m.t, m.ss, m.tt);
      input.b.emplace_back(half_vector.x, half_vector.y, m.st, exponent);
    }
  std::vector<float> values;
  for (const glm::vec4& value : gl::evaluate_shader(context.functions(), input)) values.push_back(value.x);
  return values;
}

double reference_value(const MultumFilteredMoments& m, const glm::vec3& h, double s, int shading) {
  reference::TexelMoments exact;
  exact.s = static_cast<double>(m.s);
  exact.t = static_cast<double>(m.t);
  exact.ss = static_cast<double>(m.ss);
  exact.tt = static_cast<double>(m.tt);
  exact.st = static_cast<double>(m.st);
  exact.normal = {static_cast<double>(m.normal_x), static_cast<double>(m.normal_y), static_cast<double>(m.normal_z)};
  const glm::dvec3 half_vector = glm::normalize(glm::dvec3(h));
  if (shading == MULTUM_SHADE_TOKSVIG) return reference::toksvig(exact.normal, half_vector, s);
  return reference::lean(exact, half_vector, s, shading == MULTUM_SHADE_LEAN_JACOBIAN);
}

// How far floats may be off: each input is off by 2^-24 of itself. Of LEAN that moves the distance between the slopes
// and the variances (by 2^-23 of a squared slope), in units of the standard deviation, whose square is 1/s at least.
// Of Toksvig it moves 1 - t by 1e-7 times the exponent.
double tolerance(const MultumFilteredMoments& m, const glm::vec3& h, double s, int shading) {
  if (shading == MULTUM_SHADE_TOKSVIG) return (s + 1.0) / (2.0 * M_PI) * (2e-5 + 4e-7 * s);
  const double slope2 = 1.0 + static_cast<double>(m.ss) + static_cast<double>(m.tt) +
                        (1.0 - static_cast<double>(h.z) * static_cast<double>(h.z)) /
                            (static_cast<double>(h.z) * static_cast<double>(h.z));
  const double peak =
      s / (2.0 * M_PI) * (shading == MULTUM_SHADE_LEAN_JACOBIAN ? std::pow(static_cast<double>(h.z), -3.0) : 1.0);
  return peak * std::min(1.0, 2e-5 + 2e-6 * slope2 * s);
}

class MomentAgreementTest : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Exponents, MomentAgreementTest, ::testing::Values(1.0, 20.0, 100.0, 500.0, 1e4),
                         [](const ::testing::TestParamInfo<double>& exponent) {
                           return "S" + std::to_string(static_cast<int>(exponent.param));
                         });

TEST_P(MomentAgreementTest, OpenclGlslAndDoubleAgree) {
  constexpr unsigned kSeed = 43;
  const double s = GetParam();
  const std::vector<MultumFilteredMoments> set = test_moments(kSeed);
  const std::vector<glm::vec3> half_vectors = test_half_vectors(kSeed);
  const auto context = gl::make_headless_context(gl::ContextBackend::kOsmesa);
  for (const int shading : {MULTUM_SHADE_TOKSVIG, MULTUM_SHADE_LEAN, MULTUM_SHADE_LEAN_JACOBIAN}) {
    const std::vector<float> opencl = shade_opencl(set, half_vectors, static_cast<float>(s), shading);
    const std::vector<float> glsl = shade_glsl(*context, set, half_vectors, static_cast<float>(s), shading);
    double sum = 0.0, off_opencl = 0.0, off_glsl = 0.0;
    for (std::size_t i = 0; i < set.size(); ++i)
      for (std::size_t d = 0; d < half_vectors.size(); ++d) {
        const std::size_t at = i * half_vectors.size() + d;
        const double expected = reference_value(set[i], half_vectors[d], s, shading);
        const double bound = tolerance(set[i], half_vectors[d], s, shading);
        EXPECT_NEAR(static_cast<double>(opencl[at]), expected, bound) << shading << ", " << i << ", " << d;
        EXPECT_NEAR(static_cast<double>(glsl[at]), expected, bound) << shading << ", " << i << ", " << d;
        sum += expected;
        off_opencl += std::abs(static_cast<double>(opencl[at]) - expected);
        off_glsl += std::abs(static_cast<double>(glsl[at]) - expected);
      }
    // The bounds are for the worst of them; all together are as near as floats are.
    EXPECT_LT(off_opencl, 2e-4 * sum) << shading;
    EXPECT_LT(off_glsl, 2e-4 * sum) << shading;
  }
}

// A density integrates to 1: with the Jacobian over solid angle, without it over slopes.
TEST(MomentShadingTest, LeanIsADensity) {
  reference::TexelMoments m;
  m.s = 0.2;
  m.t = -0.1;
  m.ss = 0.04 + 0.02;
  m.tt = 0.01 + 0.01;
  m.st = -0.02 + 0.005;
  for (const bool with_jacobian : {false, true}) {
    constexpr int kSteps = 800;
    constexpr double kReach = 3.0, kStep = 2.0 * kReach / kSteps;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps; ++j) {
        const double x = (i + 0.5) * kStep - kReach, y = (j + 0.5) * kStep - kReach;
        const glm::dvec3 h = glm::normalize(glm::dvec3(-x, -y, 1.0));
        const double solid_angle = with_jacobian ? h.z * h.z * h.z : 1.0;  // of a cell of slopes
        sum += reference::lean(m, h, 100.0, with_jacobian) * solid_angle * kStep * kStep;
      }
    EXPECT_NEAR(sum, 1.0, 1e-3) << with_jacobian;
  }
}

}  // namespace
}  // namespace multum
