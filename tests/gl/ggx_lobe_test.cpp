// SPDX-License-Identifier: Apache-2.0
// Compares GGX over vMF lobes as one term from a table (host/formats/brdf/ggx_lobe.h, brdf/ggx_lobe.glsl) with
// quadrature, for all roughnesses and for lobes from single directions to the whole sphere.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

#include "host/formats/brdf/ggx_lobe.h"
#include "host/formats/brdf/ggx_lobe_fit.h"
#include "host/formats/brdf/ggx_lobe_specular.h"
#include "host/lab/reference/shading.h"
#include "runtime_gl/materials/ggx_lobe_texture.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/gl/shader_harness.h"
#include "tests/gl/test_context.h"

namespace multum::gl {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRoughnesses[] = {0.05, 0.08, 0.12, 0.17, 0.23, 0.32, 0.45, 0.6, 0.75, 0.9, 1.0};
constexpr double kKappas[] = {0.03, 0.3, 1.0, 2.5, 6.0, 15.0, 40.0, 150.0, 700.0, 4e3, 3e4, 1e6};

class GgxLobeTest : public testing::Test {
 protected:
  void SetUp() override {
    context_ = make_test_context(test_backend());
    table_.emplace(make_ggx_lobe_texture(context_->functions()));
  }

  /// Evaluates MULTUM_GGX with alpha = roughness squared.
  std::vector<double> evaluate(ShaderHarnessInput& input, float alpha) {
    input.flags = {"MULTUM_GGX"};
    input.formulas = brdf_shader_text("ggx_lobe.glsl");
    input.set_uniforms = [&](const ShaderProgram& program) {
      program.set("u_alpha", alpha);
      program.set("u_ggx_lobe_table", 3);
      table_->bind(3);
    };
    std::vector<double> values;
    for (const glm::vec4& value : evaluate_shader(context_->functions(), input))
      values.push_back(static_cast<double>(value.x));
    return values;
  }

  std::unique_ptr<HeadlessContext> context_;
  std::optional<Texture> table_;
};

/// Holds the angle from the lobe's mean and the solid angle of each ring. Rings are denser near 0.
struct Rings {
  std::vector<double> angles, weights;
};

Rings rings_of(double width) {
  Rings rings;
  constexpr int kCount = 96;
  const double least = 0.02 * std::min(width, 1.0);
  for (int i = 0; i < kCount; ++i) {
    // The steps are even on a logarithmic scale and start at `least`.
    const double step = std::log(kPi / least) / kCount, begin = least * std::exp(i * step);
    const double middle = begin * std::exp(0.5 * step);
    rings.angles.push_back(middle);
    rings.weights.push_back(2.0 * kPi * std::sin(middle) * begin * std::expm1(step));
  }
  return rings;
}

TEST_F(GgxLobeTest, IsNearTheExactConvolutionAtEveryRoughness) {
  double worst = 0.0;
  for (const double roughness : kRoughnesses) {
    const double alpha = roughness * roughness;
    double of_roughness = 0.0;
    for (const double kappa : kKappas) {
      const double spread = reference::vmf_spread(kappa);
      const Rings rings = rings_of(std::sqrt(alpha * alpha + 2.0 * spread));
      ShaderHarnessInput input;
      input.expression = "vec4(multum_lobe_facets(a, b.xyz).x)";
      for (const double theta : rings.angles) {
        input.a.emplace_back(0.0, 0.0, 1.0 - spread, 1.0);
        input.b.emplace_back(std::sin(theta), 0.0, std::cos(theta), 0.0);
      }
      const std::vector<double> values = evaluate(input, static_cast<float>(alpha));
      double off = 0.0, total = 0.0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        const double exact = convolved_ggx_facets(alpha, kappa, rings.angles[i]);
        off += std::abs(values[i] - exact) * rings.weights[i];
        total += exact * rings.weights[i];
      }
      of_roughness = std::max(of_roughness, 100.0 * off / total);
    }
    std::printf("roughness %.2f, kappa 0.03 to 1e6: at most %.1f %%\n", roughness, of_roughness);
    worst = std::max(worst, of_roughness);
  }
  EXPECT_LT(worst, 4.5);
  EXPECT_GT(worst, 3.5) << "the documented bound is too wide";
}

// Compares the quadrature that the table is fitted to with a second, simpler quadrature.
TEST_F(GgxLobeTest, FitsAreToTheReference) {
  for (const double alpha : {0.01, 0.1, 0.5, 1.0})
    for (const double kappa : {0.3, 5.0, 80.0, 2000.0})
      for (const double theta : {0.0, 0.02, 0.3, 1.2, 1.5}) {
        const double exact = reference::convolved_ggx(alpha, kappa, theta);
        // The bound is the error of the reference's midpoint rule.
        EXPECT_NEAR(convolved_ggx_facets(alpha, kappa, theta) / exact, 1.0, 3e-4)
            << "alpha " << alpha << " kappa " << kappa << " theta " << theta;
      }
  EXPECT_NEAR(convolved_ggx_facets(1.0, 2000.0, 0.02) * kPi, 1.0, 1e-9) << "facets of equal density in all directions";
}

TEST_F(GgxLobeTest, ALobeOfOneNormalIsGgx) {
  for (const double roughness : kRoughnesses) {
    const double alpha = roughness * roughness;
    ShaderHarnessInput input;
    input.expression =
        "vec4(multum_lobe_facets(a, b.xyz).x / multum_ggx(u_alpha, multum_one_minus_cosine(a.xyz, "
        "b.xyz)))";
    for (int i = 0; i < 60; ++i) {
      const double theta = 1.55 * std::pow(i / 59.0, 2.0);
      input.a.emplace_back(0.0, 0.0, 1.0, 1.0);
      input.b.emplace_back(std::sin(theta), 0.0, std::cos(theta), 0.0);
    }
    // The table holds 16-bit floats, each with an error of 0.1 %. At alpha 1, the filter reaches beyond the border of
    // the table.
    for (const double ratio : evaluate(input, static_cast<float>(alpha)))
      ASSERT_NEAR(ratio, 1.0, roughness < 1.0 ? 0.01 : 0.06) << "roughness " << roughness;
  }
}

TEST_F(GgxLobeTest, DoublesAreWhatShadersCompute) {
  std::mt19937 random(20261126);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double roughness : {0.07, 0.4, 0.95}) {
    const double alpha = static_cast<double>(static_cast<float>(roughness * roughness));
    ShaderHarnessInput input;
    input.expression =
        "vec4(multum_ggx_lobe_density(multum_ggx_lobe_shape(u_ggx_lobe_table, u_alpha, a.x), u_alpha, "
        "a.x, a.y))";
    for (int i = 0; i < 500; ++i)
      input.a.emplace_back(std::pow(10.0, -5.0 * unit(random)), 2.0 * unit(random), 0.0, 0.0);
    input.b = input.a;
    const std::vector<double> values = evaluate(input, static_cast<float>(alpha));
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double spread = static_cast<double>(input.a[i].x), e = static_cast<double>(input.a[i].y);
      const double exact = ggx_lobe_density(ggx_lobe_shape(alpha, spread), alpha, spread, e);
      // Texture filters resolve the position between two texels with at least eight bits.
      ASSERT_NEAR(values[i], exact, 0.02 * exact + 1e-6) << "d " << spread << " e " << e;
    }
  }
}

// Tests the whole highlight with visibility, for random lobes, with light and view above the surface.
TEST_F(GgxLobeTest, TheHighlightInDoubleIsTheShaders) {
  std::mt19937 random(28);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto above = [&] {
    const double z = 0.05 + 0.95 * unit(random), phi = 2.0 * kPi * unit(random), s = std::sqrt(1.0 - z * z);
    return glm::dvec3(s * std::cos(phi), s * std::sin(phi), z);
  };
  for (const double roughness : {0.1, 0.4, 0.9}) {
    const auto alpha = static_cast<float>(roughness * roughness);
    ShaderHarnessInput input;
    input.expression =
        "vec4(multum_movmf_ggx_specular(u_ggx_lobe_table, a, b.xyz, vec3(0.36, 0.48, 0.8), "
        "normalize(b.xyz + vec3(0.36, 0.48, 0.8)), u_alpha))";
    for (int i = 0; i < 600; ++i) {
      const double amplitude = unit(random), length = 1.0 - std::pow(10.0, -4.0 * unit(random));
      input.a.emplace_back(glm::vec4(glm::dvec4(amplitude * length * above(), amplitude)));
      input.b.emplace_back(glm::vec3(above()), 0.0f);
    }
    const glm::dvec3 view(0.36, 0.48, 0.8);
    const std::vector<double> values = evaluate(input, alpha);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const glm::dvec3 light(input.b[i]);
      const double exact = GgxOverLobe(glm::dvec4(input.a[i]), static_cast<double>(alpha))
                               .specular(light, view, glm::normalize(light + view));
      // The tolerance again covers the eight bits of the filter. It also covers the rounding of |r| to a float, whose
      // error of 1e-7 is one thousandth of the smallest spread here.
      ASSERT_NEAR(values[i], exact, 0.03 * exact + 1e-5) << i << ", roughness " << roughness;
    }
  }
}

// Tests integral GGX(n . h) vMF(n) max(n . l, 0) dn, with the cosine of the light. Errors are relative L1 over h and l
// above the lobe's horizon, weighted by brightness.
TEST_F(GgxLobeTest, TheHighlightsCosineIsNear) {
  double worst = 0.0;
  for (const double roughness : {0.1, 0.25, 0.5, 0.75, 1.0})
    for (const double kappa : {2.0, 8.0, 40.0, 300.0}) {
      const double alpha = roughness * roughness, spread = reference::vmf_spread(kappa);
      const auto facets = [alpha](double theta) { return reference::ggx(alpha, theta); };
      ShaderHarnessInput with, without;
      with.expression = "vec4(multum_lobe_highlight(a, b.xyz, normalize(vec3(0.6, 0.3, 0.5))).x)";
      without.expression = "vec4(multum_lobe_facets(a, b.xyz).x)";
      const glm::dvec3 l = glm::normalize(glm::dvec3(0.6, 0.3, 0.5)), mu(0.0, 0.0, 1.0);
      std::vector<double> exact_cosines, weights;
      const double width = std::min(std::sqrt(alpha * alpha + 2.0 * spread), 1.0);
      for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 6; ++k) {
          const double theta = std::min(2.0 * width, 1.4) * (i + 0.5) / 6.0, phi = 2.0 * kPi * k / 6.0;
          const glm::dvec3 h(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
          with.a.emplace_back(0.0, 0.0, 1.0 - spread, 1.0);
          with.b.emplace_back(glm::vec3(h), 0.0f);
          const auto exact = reference::highlight(facets, 1e-3, kappa, mu, h, l);
          exact_cosines.push_back(exact.with_cosine / exact.without_cosine);
          weights.push_back(convolved_ggx_facets(alpha, kappa, theta) * std::sin(theta));
        }
      without.a = with.a;
      without.b = with.b;
      const auto highlights = evaluate(with, static_cast<float>(alpha));
      const auto densities = evaluate(without, static_cast<float>(alpha));
      double off = 0.0, total = 0.0;
      for (std::size_t i = 0; i < weights.size(); ++i) {
        off += std::abs(highlights[i] / densities[i] - exact_cosines[i]) * weights[i];
        total += exact_cosines[i] * weights[i];
      }
      std::printf("roughness %.2f, kappa %g: error of the cosine %.2f %%\n", roughness, kappa, 100.0 * off / total);
      worst = std::max(worst, 100.0 * off / total);
    }
  EXPECT_LT(worst, 6.5);
  EXPECT_GT(worst, 5.5) << "the documented bound is too wide";
}

// Returns tangents of n (Duff et al. 2017).
std::pair<glm::dvec3, glm::dvec3> tangents(const glm::dvec3& n) {
  const double side = n.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (side + n.z), b = n.x * n.y * a;
  return {{1.0 + side * n.x * n.x * a, side * b, -side * n.x}, {b, side + n.y * n.y * a, -n.y}};
}

// Returns the direction at azimuth phi whose cosine with n is 1 - e.
glm::dvec3 beside(const glm::dvec3& n, double e, double phi) {
  const auto [s, t] = tangents(n);
  const double across = std::sqrt(e * (2.0 - e));
  return (1.0 - e) * n + across * (std::cos(phi) * s + std::sin(phi) * t);
}

// Estimates integral GGX(n . h) V(n . l, n . v) max(n . l, 0) vMF(n) dn. Half of the normals follow the facets, and the
// other half follow the lobe (Veach and Guibas 1995, the balance heuristic), at the points of Roberts' sequence.
double sampled_highlight(double alpha, double kappa, const glm::dvec3& mu, const glm::dvec3& h, const glm::dvec3& l,
                         const glm::dvec3& v) {
  constexpr int kSamples = 2048;
  const auto one_minus_cosine = [](const glm::dvec3& a, const glm::dvec3& b) { return 0.5 * glm::dot(a - b, a - b); };
  double sum = 0.0;
  for (int i = 0; i < 2 * kSamples; ++i) {
    const double x = std::fmod(0.5 + (i / 2 + 1) * 0.7548776662466927, 1.0);
    const double phi = 2.0 * kPi * std::fmod(0.5 + (i / 2 + 1) * 0.5698402909980532, 1.0);
    const double cosine = std::sqrt((1.0 - x) / (1.0 + (alpha * alpha - 1.0) * x));
    const double drawn = std::clamp(-std::log1p(x * std::expm1(-2.0 * kappa)) / kappa, 0.0, 2.0);
    const glm::dvec3 n = i % 2 == 0 ? beside(h, 1.0 - cosine, phi) : beside(mu, drawn, phi);
    const double n_l = glm::dot(n, l), n_v = std::max(glm::dot(n, v), 1e-6), n_h = glm::dot(n, h);
    if (n_l <= 0.0 || n_h <= 0.0) continue;
    const double facets = reference::ggx(alpha, std::acos(std::min(n_h, 1.0)));
    const double lobe = kappa / (-2.0 * kPi * std::expm1(-2.0 * kappa)) * std::exp(-kappa * one_minus_cosine(n, mu));
    sum += facets * lobe / (facets * n_h + lobe) * n_l * reference::smith_visibility(alpha, n_l, n_v);
  }
  return sum / kSamples;
}

// Tests the highlight with visibility by its relative L1 error over half vectors within twice the width of the
// highlight. Lights and views are above the surface; lobes are tilted by up to 40 degrees.
TEST_F(GgxLobeTest, TheHighlightWithVisibilityIsNear) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  double worst = 0.0, worst_of_narrow = 0.0;
  for (const double roughness : {0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0})
    for (const double kappa : {0.03, 0.5, 2.0, 8.0, 40.0, 300.0, 1e4, 1e6}) {
      const double alpha = roughness * roughness, spread = reference::vmf_spread(kappa);
      const double width = std::min(1.2, 2.0 * std::sqrt(alpha * alpha + 2.0 * spread));
      double off = 0.0, total = 0.0;
      for (int found = 0; found < 60;) {
        const glm::dvec3 mu =
            beside({0.0, 0.0, 1.0}, 1.0 - std::cos(0.7 * std::sqrt(unit(random))), 2.0 * kPi * unit(random));
        const glm::dvec3 h = beside(mu, (1.0 - std::cos(width)) * unit(random), 2.0 * kPi * unit(random));
        const glm::dvec3 l = beside({0.0, 0.0, 1.0}, 0.95 * unit(random), 2.0 * kPi * unit(random));
        const glm::dvec3 v = 2.0 * glm::dot(l, h) * h - l;
        if (glm::dot(l, h) <= 0.02 || v.z < 0.05 || h.z < 0.05) continue;
        ++found;
        const double exact = sampled_highlight(alpha, kappa, mu, h, l, v);
        const GgxOverLobe shader({(1.0 - spread) * mu, 1.0}, alpha);
        off += std::abs(shader.specular(l, v, h) - exact);
        total += exact;
      }
      std::printf("roughness %.2f, kappa %g: error of the highlight %.1f %%\n", roughness, kappa, 100.0 * off / total);
      double& bound = kappa >= 40.0 ? worst_of_narrow : worst;
      bound = std::max(bound, 100.0 * off / total);
    }
  EXPECT_LT(worst, 18.5);
  EXPECT_GT(worst, 17.0) << "the documented bound is too wide";
  EXPECT_LT(worst_of_narrow, 8.0);
  EXPECT_GT(worst_of_narrow, 7.0) << "the documented bound is too wide";
}

TEST_F(GgxLobeTest, HardCasesAreFinite) {
  for (const float alpha : {1e-6f, 0.0025f, 0.5f, 1.0f}) {
    ShaderHarnessInput input;
    input.expression = "vec4(multum_lobe_highlight(a, b.xyz, vec3(0.0, 0.0, 1.0)).x)";
    for (const glm::vec4 lobe :
         {glm::vec4(0.0f, 0.0f, 1.0f, 1.0f), glm::vec4(0.0f, 0.0f, 1.001f, 1.0f), glm::vec4(0.0f),
          glm::vec4(0.0f, 0.0f, 0.0f, 1.0f), glm::vec4(1e-8f), glm::vec4(0.0f, 0.0f, 0.9999999f, 1.0f)})
      for (const double theta : {0.0, 1e-4, 1.57, 1.5708, 1.6, 3.1415926}) {
        input.a.push_back(lobe);
        input.b.emplace_back(std::sin(theta), 0.0, std::cos(theta), 0.0);
      }
    for (const double value : evaluate(input, alpha)) ASSERT_TRUE(std::isfinite(value) && value >= 0.0) << alpha;
  }
}

}  // namespace
}  // namespace multum::gl
