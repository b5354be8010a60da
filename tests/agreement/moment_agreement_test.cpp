// SPDX-License-Identifier: Apache-2.0
// Compares two implementations of the shading of moments: the OpenCL code with which a bake measures its own error
// (kernels/device/moment_shading.clh), and the GLSL code that renders (runtime_gl/shaders/common/moment_shading.glsl).
// Both are also compared with double precision, first on hard cases, then on random moments.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "host/formats/opencl/device.h"
#include "host/lab/reference/moments.h"
#include "kernels/shared/moments.h"
#include "runtime_gl/context/headless_context.h"
#include "tests/fixtures/random_values.h"
#include "tests/gl/shader_harness.h"

namespace multum {
namespace {

using testing::uniform24;

// Returns moments rounded to floats, with a mean normal of any length.
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
  rounded.ss *= 0.9995f;  // rounding to 16-bit floats may leave a second moment below the square of the mean
  rounded.st *= 1.0005f;
  all.push_back(rounded);
  std::mt19937 random(seed);
  for (int i = 0; i < 200; ++i)
    all.push_back(moments(2.0 * uniform24(random) - 1.0, 2.0 * uniform24(random) - 1.0,
                          std::pow(10.0, -3.0 * uniform24(random)), std::pow(10.0, -3.0 * uniform24(random)),
                          1.9 * uniform24(random) - 0.95, uniform24(random)));
  return all;
}

std::vector<glm::vec3> test_half_vectors(unsigned seed) {
  std::vector<glm::vec3> all = {{0.0f, 0.0f, 1.0f}, {0.6f, 0.0f, 0.8f}, {0.0f, -0.6f, 0.8f}, {0.99f, 0.0f, 0.1410674f}};
  std::mt19937 random(seed);
  for (int i = 0; i < 20; ++i) {
    const double z = 0.05 + 0.95 * uniform24(random), phi = 2.0 * M_PI * uniform24(random),
                 side = std::sqrt(1.0 - z * z);
    all.emplace_back(glm::normalize(glm::vec3(glm::dvec3(side * std::cos(phi), side * std::sin(phi), z))));
  }
  return all;
}

// values by [moments][half vector]
std::vector<float> shade_moments_opencl(const std::vector<MultumFilteredMoments>& set,
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

std::vector<float> shade_moments_glsl(const gl::HeadlessContext& context, const std::vector<MultumFilteredMoments>& set,
                                      const std::vector<glm::vec3>& half_vectors, float exponent, int shading) {
  // A half vector of the upper hemisphere is given by its x and y.
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

// Holds a set of moments and a half vector in double precision.
struct ExactInput {
  reference::TexelMoments m;
  glm::dvec3 h;

  ExactInput(const MultumFilteredMoments& from, const glm::vec3& half_vector)
      : h(glm::normalize(glm::dvec3(half_vector))) {
    m.s = static_cast<double>(from.s);
    m.t = static_cast<double>(from.t);
    m.ss = static_cast<double>(from.ss);
    m.tt = static_cast<double>(from.tt);
    m.st = static_cast<double>(from.st);
    m.normal = {static_cast<double>(from.normal_x), static_cast<double>(from.normal_y),
                static_cast<double>(from.normal_z)};
  }

  double value(double s, int shading) const {
    if (shading == MULTUM_SHADE_TOKSVIG) return reference::toksvig(m.normal, h, s);
    return reference::lean(m, h, s, shading == MULTUM_SHADE_LEAN_JACOBIAN);
  }
};

// Returns the allowed error of single precision. Every operation rounds once, so this error is the change of the exact
// value when each input changes by kRoundings float roundings. The error of a product of slopes is relative to the
// product, even if most of the product cancels later. GLSL computes the half vector's z as the root of 1 - x^2 - y^2.
// The exponential adds 1e-5 of the value, which is the error of exp2 for large arguments. Results that underflow are
// negligible compared with a peak. The measured error is a third of what kRoundings = 8 allows.
double tolerance(const ExactInput& exact, double s, int shading) {
  constexpr double kRoundings = 8.0, kStep = kRoundings * 0x1p-24;
  const double value = exact.value(s, shading), z = exact.h.z;
  double sum = 1e-5 * value + 1e-30 * s / (z * z * z);
  const auto add = [&](const auto& move) {
    double most = 0.0;
    for (const double step : {-kStep, kStep}) {
      ExactInput moved = exact;
      move(moved, step);
      most = std::max(most, std::abs(moved.value(s, shading) - value));
    }
    sum += most;
  };
  for (int c = 0; c < 3; ++c) {
    add([&](ExactInput& in, double step) { in.h[c] *= 1.0 + step / (c == 2 ? z * z : 1.0); });
    if (shading == MULTUM_SHADE_TOKSVIG) add([&](ExactInput& in, double step) { in.m.normal[c] *= 1.0 + step; });
  }
  if (shading == MULTUM_SHADE_TOKSVIG) return sum;
  add([](ExactInput& in, double step) { in.m.s *= 1.0 + step; });
  add([](ExactInput& in, double step) { in.m.t *= 1.0 + step; });
  add([](ExactInput& in, double step) { in.m.ss *= 1.0 + step; });
  add([](ExactInput& in, double step) { in.m.tt *= 1.0 + step; });
  add([](ExactInput& in, double step) { in.m.st += step * std::sqrt(in.m.ss * in.m.tt); });
  return sum;
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
    const std::vector<float> opencl = shade_moments_opencl(set, half_vectors, static_cast<float>(s), shading);
    const std::vector<float> glsl = shade_moments_glsl(*context, set, half_vectors, static_cast<float>(s), shading);
    double sum = 0.0, off_opencl = 0.0, off_glsl = 0.0;
    int seen = 0, tight = 0;  // counts of values that matter, and of values with a tolerance below 1 %
    for (std::size_t i = 0; i < set.size(); ++i)
      for (std::size_t d = 0; d < half_vectors.size(); ++d) {
        const std::size_t at = i * half_vectors.size() + d;
        const ExactInput exact(set[i], half_vectors[d]);
        const double expected = exact.value(s, shading), bound = tolerance(exact, s, shading);
        seen += expected > 1e-6 * s ? 1 : 0;
        tight += expected > 1e-6 * s && bound < 0.01 * expected ? 1 : 0;
        EXPECT_NEAR(static_cast<double>(opencl[at]), expected, bound) << shading << ", " << i << ", " << d;
        EXPECT_NEAR(static_cast<double>(glsl[at]), expected, bound) << shading << ", " << i << ", " << d;
        sum += expected;
        off_opencl += std::abs(static_cast<double>(opencl[at]) - expected);
        off_glsl += std::abs(static_cast<double>(glsl[at]) - expected);
      }
    // The bounds above apply to the worst value. The mean error is about as large as one float rounding.
    EXPECT_LT(off_opencl, 2e-4 * sum) << shading;
    EXPECT_LT(off_glsl, 2e-4 * sum) << shading;
    EXPECT_GT(seen, 250) << shading;
    EXPECT_GT(tight, 0.95 * seen) << shading << ": the bounds are too wide to be useful";
  }
}

// The density integrates to 1, both over solid angles (with the Jacobian) and over slopes (without it).
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
        const double solid_angle = with_jacobian ? h.z * h.z * h.z : 1.0;  // the solid angle of one cell of slopes
        sum += reference::lean(m, h, 100.0, with_jacobian) * solid_angle * kStep * kStep;
      }
    EXPECT_NEAR(sum, 1.0, 1e-3) << with_jacobian;
  }
}

}  // namespace
}  // namespace multum
