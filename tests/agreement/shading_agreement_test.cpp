// SPDX-License-Identifier: Apache-2.0
// Compares two implementations of the shading of vMF lobes: the OpenCL code with which a bake measures its own error
// (kernels/device/vmf_shading.clh), and the GLSL code that renders (runtime_gl/shaders/common/movmf_shading.glsl). Both
// are also compared with quadrature in double precision, first on hard cases, then on random lobes.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/bakes/accuracy/highlight.h"
#include "host/formats/brdf/brdf_text.h"
#include "host/formats/opencl/device.h"
#include "host/lab/reference/shading.h"
#include "runtime_gl/context/headless_context.h"
#include "tests/fixtures/random_values.h"
#include "tests/gl/shader_harness.h"

namespace multum {
namespace {

using testing::random_direction;
using testing::uniform24;

struct Lobes {
  std::vector<glm::vec4> lobes;  // (a r, a)
  std::vector<double> kappa;     // one value per lobe, which is infinite for a single direction
};

void add(Lobes& set, const glm::dvec3& mu, double kappa, double amplitude) {
  const double r = std::isinf(kappa) ? 1.0 : 1.0 - reference::vmf_spread(kappa);
  set.lobes.emplace_back(glm::vec4(amplitude * r * mu.x, amplitude * r * mu.y, amplitude * r * mu.z, amplitude));
  set.kappa.push_back(kappa);
}

Lobes test_lobes(unsigned seed) {
  Lobes set;
  const glm::dvec3 equator(1.0, 0.0, 0.0), up(0.0, 0.0, 1.0);
  for (double kappa : {1e-3, 0.1, 1.0, 10.0, 100.0, 1e4, 1e6, static_cast<double>(INFINITY)})
    for (double amplitude : {1.0, 0.02, 1.0 / 32767.0}) {
      add(set, equator, kappa, amplitude);
      add(set, up, kappa, amplitude);
    }
  add(set, up, 10.0, 0.0);  // no lobe
  std::mt19937 random(seed);
  for (int i = 0; i < 200; ++i) {
    const double exponent = uniform24(random);
    add(set, random_direction(random), 0.5 * std::pow(2e4, exponent), 1.0);
  }
  return set;
}

// Returns one highlight, or Lambert's cosine, as the OpenCL kernel computes it, indexed by [lobe][direction].
std::vector<float> shade_opencl(const std::vector<glm::vec4>& lobes, const std::vector<glm::vec3>& directions,
                                const MultumHighlight& shaded, bool lambert) {
  static Device device = Device::open("");
  std::vector<glm::vec4> vectors;
  for (const glm::vec3& d : directions) vectors.emplace_back(d, 0.0f);
  const DeviceBuffer lobe_buffer = device.wrap_buffer(lobes.data(), lobes.size() * sizeof(glm::vec4), "lobes");
  const DeviceBuffer direction_buffer =
      device.wrap_buffer(vectors.data(), vectors.size() * sizeof(glm::vec4), "directions");
  const DeviceBuffer highlight = device.wrap_buffer(&shaded, sizeof(shaded), "highlight");
  std::vector<float> values(lobes.size() * directions.size(), -1.0f);
  const DeviceBuffer out = device.make_buffer(values.size() * sizeof(float), "values");
  const auto count = static_cast<int>(directions.size());
  device.kernel("movmf_shade", "movmf_shade", {1, 1, false})
      .launch({lobes.size()}, lobe_buffer, direction_buffer, direction_buffer, highlight, out,
              static_cast<int>(lobes.size()), lambert ? 0 : count, lambert ? count : 0, lambert ? 0 : 1);
  device.read(out, values.data(), values.size() * sizeof(float));
  std::vector<float> by_lobe;  // the kernel writes [direction][lobe]
  for (std::size_t i = 0; i < lobes.size(); ++i)
    for (std::size_t d = 0; d < directions.size(); ++d) by_lobe.push_back(values[d * lobes.size() + i]);
  return by_lobe;
}

// An exponent of 0 selects Lambert's cosine.
std::vector<float> shade_opencl(const std::vector<glm::vec4>& lobes, const std::vector<glm::vec3>& directions,
                                float exponent) {
  return shade_opencl(lobes, directions, shaded_highlight(static_cast<double>(exponent)), exponent == 0.0f);
}

std::vector<float> shade_glsl(const gl::HeadlessContext& context, const std::vector<glm::vec4>& lobes,
                              const std::vector<glm::vec3>& directions, float exponent,
                              const std::string& expression = "vec4(multum_movmf_blinn_phong(a, b.xyz, b.w))") {
  gl::ShaderHarnessInput input{exponent == 0.0f ? "vec4(multum_movmf_lambert(a, b.xyz))" : expression, {}, {}, nullptr};
  for (const glm::vec4& lobe : lobes)
    for (const glm::vec3& d : directions) {
      input.a.push_back(lobe);
      input.b.emplace_back(d, exponent);
    }
  std::vector<float> values;
  for (const glm::vec4& value : gl::evaluate_shader(context.functions(), input)) values.push_back(value.x);
  return values;
}

class ShadingAgreementTest : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Exponents, ShadingAgreementTest, ::testing::Values(0.0, 5.0, 20.0, 100.0, 500.0, 1e5),
                         [](const ::testing::TestParamInfo<double>& exponent) {
                           return exponent.param == 0.0
                                      ? std::string("Lambert")
                                      : std::string("S").append(std::to_string(static_cast<int>(exponent.param)));
                         });

// Both compute in single precision. The exponent kappa (1 - cosine), with kappa up to 1e6, has a relative error of
// 1e-7. Hence the two peaks agree to 2e-3 for the sharpest lobes and to 1e-5 for usual lobes. The bound is relative to
// the lobe's peak.
TEST_P(ShadingAgreementTest, OpenclEqualsGlsl) {
  const auto exponent = static_cast<float>(GetParam());
  constexpr unsigned kSeed = 41;
  const Lobes set = test_lobes(kSeed);
  std::mt19937 random(kSeed);
  std::vector<glm::vec3> directions = {{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}};
  for (int i = 0; i < 20; ++i) directions.emplace_back(random_direction(random));
  const auto opencl = shade_opencl(set.lobes, directions, exponent);
  const auto context = gl::make_headless_context(gl::ContextBackend::kOsmesa);
  const auto glsl = shade_glsl(*context, set.lobes, directions, exponent);
  ASSERT_EQ(opencl.size(), glsl.size());
  const float unit = exponent == 0.0f ? 1.0f : (exponent + 1.0f) / 6.2831853f;
  for (std::size_t i = 0; i < opencl.size(); ++i) {
    ASSERT_TRUE(std::isfinite(opencl[i]) && std::isfinite(glsl[i])) << "lobe " << i / directions.size();
    const float peak = std::max(set.lobes[i / directions.size()].w * unit, 1e-9f);
    EXPECT_NEAR(opencl[i] / peak, glsl[i] / peak, exponent > 1e4f ? 2e-3f : 3e-5f) << "lobe " << i / directions.size();
  }
}

// Returns the sum that multum_lobe_facets() of brdf/terms.glsl computes from uniforms. The test harness has no
// uniforms.
std::string terms_expression(const MultumHighlight& f) {
  const char* kSpread = "multum_movmf_spread(a)";
  const char* kOneMinusCosine = "multum_one_minus_cosine(multum_movmf_mean_direction(a), b.xyz)";
  std::string sum = "0.0";
  for (int i = 0; i < f.term_count; ++i)
    sum += fmt::format(" + {:.9e} * multum_term({}, {:.9e}, {})", f.weights[i], kSpread, f.spreads[i], kOneMinusCosine);
  return fmt::format("vec4(a.w <= 1e-6 ? 0.0 : a.w * max({}, 0.0))", sum);
}

// Tests facet distributions that are sums of vMFs. A bake uses these sums to measure its error for GGX and other BRDFs
// (host/bakes/accuracy/highlight.h).
TEST(TermsAgreementTest, OpenclEqualsGlsl) {
  const Lobes set = test_lobes(43);
  std::mt19937 random(43);
  std::vector<glm::vec3> directions = {{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}};
  for (int i = 0; i < 20; ++i) directions.emplace_back(random_direction(random));
  const auto context = gl::make_headless_context(gl::ContextBackend::kOsmesa);
  for (const char* text : {"ggx:0.3", "ggx:0.7", "torrance-sparrow:0.1", "cook-torrance:0.4", "charlie:0.6"}) {
    const Brdf brdf = parse_brdf("brdf", text, 4);
    const MultumHighlight f = shaded_highlight(brdf);
    ASSERT_EQ(f.term_count, is_vmf_sum(brdf) ? 4 : 1);
    const auto opencl = shade_opencl(set.lobes, directions, f, false);
    const auto glsl = shade_glsl(*context, set.lobes, directions, 1.0f, terms_expression(f));
    const auto peak = static_cast<float>(std::max(grey_density(brdf, 0.0), grey_density(brdf, 0.999)));
    // Charlie's terms cancel each other: their sum is a hundredth of their size.
    const float bound = brdf.kind == BrdfKind::kCharlie ? 2e-4f : 3e-5f;
    for (std::size_t i = 0; i < opencl.size(); ++i) {
      const float unit = std::max(set.lobes[i / directions.size()].w * peak, 1e-9f);
      ASSERT_NEAR(opencl[i] / unit, glsl[i] / unit, bound) << text << ", lobe " << i / directions.size();
    }
  }
}

// Measures the relative L1 error over the angle, compared with the exact convolution. tools/lab/fit_shading.py states
// the bounds.
TEST_P(ShadingAgreementTest, OpenclEqualsQuadrature) {
  const double exponent = GetParam();
  if (exponent > 2000.0) GTEST_SKIP() << "the quadrature supports exponents up to 2000";
  const double bound = exponent == 0.0 ? 0.0025 : exponent < 20.0 ? 0.018 : exponent < 100.0 ? 0.0085 : 0.003;
  for (double kappa : {0.5, 2.0, 10.0, 50.0, 200.0, 2000.0}) {
    Lobes set;
    add(set, {0.0, 0.0, 1.0}, kappa, 1.0);
    constexpr int kAngles = 100;
    std::vector<glm::vec3> directions;
    std::vector<double> theta;
    for (int i = 0; i < kAngles; ++i) {
      theta.push_back((i + 0.5) / kAngles * M_PI / 2);
      directions.emplace_back(std::sin(theta.back()), 0.0, std::cos(theta.back()));
    }
    const auto found = shade_opencl(set.lobes, directions, static_cast<float>(exponent));
    double difference = 0.0, total = 0.0;
    for (std::size_t i = 0; i < theta.size(); ++i) {
      const double exact = exponent == 0.0 ? reference::convolved_lambert(kappa, theta[i])
                                           : reference::convolved_blinn_phong(exponent, kappa, theta[i]);
      difference += std::abs(static_cast<double>(found[i]) - exact) * std::sin(theta[i]);
      total += exact * std::sin(theta[i]);
    }
    EXPECT_LT(difference / total, bound) << "kappa " << kappa;
  }
}

// Returns the bound of docs/contributing/ALGORITHMS.md for exponents of at least `s`. The bound holds for the kernel
// and for GLSL, which agree.
double stated_bound(double s) {
  return s < 2.0 ? 0.07 : s < 3.0 ? 0.04 : s < 5.0 ? 0.028 : s < 20.0 ? 0.018 : s < 100.0 ? 0.0085 : 0.0027;
}

// Covers the whole range of exponents. The samples are dense at kappa 2 to 5, where the error is largest.
TEST(ShadingBounds, HoldOverADenseGrid) {
  constexpr int kAngles = 60;
  double worst_of_one = 0.0;
  for (const double s : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 50.0, 100.0, 1000.0})
    for (const double kappa : {0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 60.0, 300.0}) {
      const double reach = std::min(M_PI / 2, 6.0 / std::sqrt(s) + 6.0 / std::sqrt(kappa));
      Lobes set;
      add(set, {0.0, 0.0, 1.0}, kappa, 1.0);
      std::vector<glm::vec3> directions;
      std::vector<double> exact, sines;
      for (int i = 0; i < kAngles; ++i) {
        const double theta = (i + 0.5) / kAngles * reach;
        directions.emplace_back(std::sin(theta), 0.0, std::cos(theta));
        sines.push_back(std::sin(theta));
        exact.push_back(reference::convolved_blinn_phong(s, kappa, theta));
      }
      const std::vector<float> found = shade_opencl(set.lobes, directions, static_cast<float>(s));
      double difference = 0.0, total = 0.0;
      for (std::size_t i = 0; i < exact.size(); ++i) {
        difference += std::abs(static_cast<double>(found[i]) - exact[i]) * sines[i];
        total += exact[i] * sines[i];
      }
      EXPECT_LT(difference / total, stated_bound(s)) << "s " << s << ", kappa " << kappa;
      if (s == 1.0) worst_of_one = std::max(worst_of_one, difference / total);
    }
  EXPECT_GT(worst_of_one, 0.06) << "the stated bound is too wide";
}

// Tests highlights of random lobes for random light and view directions, as on a surface.
struct Highlights {
  std::vector<glm::vec4> lobes, half_vectors, lights;  // the w component of a half vector is the kappa of the facets
};

glm::dvec3 within(std::mt19937& random, double degrees) {
  const double z = 1.0 - (1.0 - std::cos(degrees * M_PI / 180.0)) * static_cast<double>(uniform24(random));
  const double phi = 2.0 * M_PI * static_cast<double>(uniform24(random)), radius = std::sqrt(1.0 - z * z);
  return {radius * std::cos(phi), radius * std::sin(phi), z};
}

void add(Highlights& set, double kappa, double facet_kappa, std::mt19937& random) {
  const glm::dvec3 l = within(random, 90.0), v = within(random, 90.0), mu = within(random, 40.0);
  set.lobes.emplace_back(glm::dvec4((1.0 - reference::vmf_spread(kappa)) * mu, 1.0));
  set.half_vectors.emplace_back(glm::dvec4(glm::normalize(l + v), facet_kappa));
  set.lights.emplace_back(glm::dvec4(l, 0.0));
}

std::vector<float> highlight_cosines_opencl(const Highlights& set) {
  static Device device = Device::open("");
  const auto wrapped = [&](const std::vector<glm::vec4>& list, const char* what) {
    return device.wrap_buffer(list.data(), list.size() * sizeof(glm::vec4), what);
  };
  const DeviceBuffer lobes = wrapped(set.lobes, "lobes"), half_vectors = wrapped(set.half_vectors, "half vectors"),
                     lights = wrapped(set.lights, "lights");
  std::vector<float> values(set.lobes.size(), -1.0f);
  const DeviceBuffer out = device.make_buffer(values.size() * sizeof(float), "values");
  device.kernel("probe_numerics", "probe_highlight_cosine", {4, 1, false})
      .launch({values.size(), 16}, lobes, half_vectors, lights, out, static_cast<int>(values.size()));
  device.read(out, values.data(), values.size() * sizeof(float));
  return values;
}

// The mean direction is rotated by an angle that depends on the lobe's spread. The spread has a rounding error of 6e-8,
// which is 1e-4 of the spread of the sharpest lobe.
TEST(HighlightCosineAgreementTest, OpenclEqualsGlsl) {
  std::mt19937 random(47);
  const auto context = gl::make_headless_context(gl::ContextBackend::kOsmesa);
  const glm::vec3 l = glm::normalize(glm::vec3(0.5f, -0.3f, 0.6f));
  Highlights set;
  gl::ShaderHarnessInput input{
      fmt::format("vec4(multum_movmf_highlight_cosine(a, b.xyz, vec3({}, {}, {}), b.w))", l.x, l.y, l.z),
      {},
      {},
      nullptr};
  for (const double kappa : {1e-3, 0.5, 10.0, 100.0, 2e3})
    for (const double facet_kappa : {0.5, 5.0, 100.0, 1e4})
      for (int i = 0; i < 20; ++i) {
        add(set, kappa, facet_kappa, random);
        set.lights.back() = glm::vec4(l, 0.0f);
        input.a.push_back(set.lobes.back());
        input.b.push_back(set.half_vectors.back());
      }
  const std::vector<float> opencl = highlight_cosines_opencl(set);
  const std::vector<glm::vec4> glsl = gl::evaluate_shader(context->functions(), input);
  ASSERT_EQ(opencl.size(), glsl.size());
  for (std::size_t i = 0; i < opencl.size(); ++i) ASSERT_NEAR(opencl[i], glsl[i].x, 2e-4f) << i;
}

// Returns the relative L1 error of the highlight, including its cosine, over lights, eyes and lobes.
// docs/contributing/ALGORITHMS.md states the bounds. The convolution is exact here, because another test checks the
// bounds of the approximate one.
double highlight_error(const std::function<double(double)>& f, double facet_kappa, double kappa) {
  std::mt19937 random(53);
  Highlights set;
  for (int i = 0; i < 40; ++i) add(set, kappa, facet_kappa, random);
  const std::vector<float> found = highlight_cosines_opencl(set);
  double difference = 0.0, total = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const reference::Highlight exact =
        reference::highlight(f, facet_kappa, kappa, glm::normalize(glm::dvec3(set.lobes[i])),
                             glm::normalize(glm::dvec3(set.half_vectors[i])), glm::dvec3(set.lights[i]));
    difference += std::abs(static_cast<double>(found[i]) * exact.without_cosine - exact.with_cosine);
    total += exact.with_cosine;
  }
  return difference / total;
}

TEST(HighlightCosineAgreementTest, OpenclEqualsQuadrature) {
  for (const double kappa : {0.5, 2.0, 5.0, 15.0, 50.0, 1000.0}) {
    for (const double s : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 500.0}) {
      const auto f = [s](double theta) { return reference::blinn_phong(s, theta); };
      const double error = highlight_error(f, reference::vmf_kappa(1.0 / (s + 2.0)), kappa);
      EXPECT_LT(error, s < 5.0 ? 0.055 : s < 20.0 ? 0.012 : 0.0025) << "s " << s << ", kappa " << kappa;
    }
    for (const double facet_kappa : {0.5, 2.0, 8.0, 50.0, 500.0}) {
      const auto f = [=](double theta) { return reference::vmf_density(facet_kappa, theta); };
      EXPECT_LT(highlight_error(f, facet_kappa, kappa), 0.003) << "facets " << facet_kappa << ", kappa " << kappa;
    }
  }
}

}  // namespace
}  // namespace multum
