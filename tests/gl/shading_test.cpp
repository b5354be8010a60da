// SPDX-License-Identifier: Apache-2.0
// Compares the GLSL shading functions with two computations in double precision: the same formula, and the exact
// convolution by quadrature.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "host/lab/reference/shading.h"
#include "tests/gl/shader_harness.h"
#include "tests/gl/test_context.h"

namespace multum::gl {
namespace {

struct Case {
  double amplitude;
  double spread;
  double theta;
  double parameter;  // s, sigma, unused
};

/// Appends a lobe along an oblique mean direction and a unit vector `theta` away from it.
void append(const Case& c, ShaderHarnessInput& input) {
  const double mu[3] = {0.36, -0.48, 0.8};
  const double side[3] = {0.8, 0.6, 0.0};
  const double r = 1.0 - c.spread;
  double w[3];
  for (int i = 0; i < 3; ++i) w[i] = std::cos(c.theta) * mu[i] + std::sin(c.theta) * side[i];
  const double a = c.amplitude;
  input.a.emplace_back(a * r * mu[0], a * r * mu[1], a * r * mu[2], a);
  input.b.emplace_back(w[0], w[1], w[2], c.parameter);
}

class ShadingTest : public testing::Test {
 protected:
  void SetUp() override { context_ = make_test_context(test_backend()); }
  std::vector<double> evaluate(const std::string& expression, const std::vector<Case>& cases) {
    ShaderHarnessInput input{"vec4(" + expression + ")", {}, {}, nullptr};
    for (const Case& c : cases) append(c, input);
    std::vector<double> values;
    for (const glm::vec4& value : evaluate_shader(context_->functions(), input))
      values.push_back(static_cast<double>(value.x));
    return values;
  }
  std::unique_ptr<HeadlessContext> context_;
};

std::vector<Case> angles(double spread, double s, double theta_max, int count) {
  std::vector<Case> cases;
  for (int i = 0; i < count; ++i) cases.push_back({1.0, spread, theta_max * (i + 0.5) / count, s});
  return cases;
}

TEST_F(ShadingTest, InverseOfMeanCosine) {
  std::vector<Case> cases;
  std::vector<double> kappas;
  for (double kappa = 1e-3; kappa < 1e5; kappa *= 1.3) {
    kappas.push_back(kappa);
    cases.push_back({1.0, 0.0, 0.0, reference::vmf_spread(kappa)});
  }
  const std::vector<double> values = evaluate("multum_vmf_kappa(b.w)", cases);
  // The polynomial's error is 2.3e-4. Below kappa 0.1, the rounding of the difference 1 - q adds an error of 6e-8 /
  // |r|.
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(values[i] / kappas[i], 1.0, 2.4e-4 + 4e-7 / kappas[i]) << "kappa " << kappas[i];
}

TEST_F(ShadingTest, BlinnPhongEqualsItsFormulaInDouble) {
  for (const double s : {1.0, 5.0, 20.0, 100.0, 2000.0, 1e5})
    for (const double spread : {0.0, 1e-6, 1e-4, 0.01, 0.1, 0.5, 0.9, 1.0}) {
      const double peak = reference::product_blinn_phong(s, spread, 0.0);
      const double width = std::min(0.5 * std::numbers::pi, 4.0 * std::sqrt(spread + 1.0 / (s + 2.0)));
      const std::vector<Case> cases = angles(spread, s, width, 40);
      const std::vector<double> values = evaluate("multum_movmf_blinn_phong(a, b.xyz, b.w)", cases);
      for (std::size_t i = 0; i < values.size(); ++i) {
        const double expected = reference::product_blinn_phong(s, spread, cases[i].theta);
        // The error of the inverse, 2.3e-4, counts twice because it changes both the scale and the exponent. The spread
        // a - |a r| has a rounding error of 1e-7, which is not negligible compared with 1/(s+2).
        EXPECT_NEAR(values[i], expected, peak * (6e-4 + 4e-7 * (s + 2.0)))
            << "s " << s << " spread " << spread << " theta " << cases[i].theta;
      }
    }
}

TEST_F(ShadingTest, CosinePowerKeepsItsPrecisionAtHighExponents) {
  ShaderHarnessInput input{"vec4(multum_blinn_phong(b.x, b.y))", {}, {}, nullptr};
  for (const float s : {10.0f, 1e3f, 1e5f})
    for (int i = 0; i <= 20; ++i) input.b.emplace_back(s, 0.3f * static_cast<float>(i) / s, 0.0f, 0.0f);
  input.a = input.b;
  const std::vector<glm::vec4> values = evaluate_shader(context_->functions(), input);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double s = static_cast<double>(input.b[i].x);
    const double e = static_cast<double>(input.b[i].y);
    const double expected = (s + 1.0) / (2.0 * std::numbers::pi) * std::exp(s * std::log1p(-e));
    // The argument of exp() is rounded and can be as large as 6. A plain log(1 - e) would have an error of 6e-3 at s =
    // 1e5.
    EXPECT_NEAR(static_cast<double>(values[i].x) / expected, 1.0, 1e-5) << "s " << s << " e " << e;
  }
}

/// Returns the relative L1 error in per cent over the hemisphere around the mean, weighted by solid angle.
double relative_l1(const std::vector<Case>& cases, const std::vector<double>& values,
                   const std::vector<double>& exact) {
  double off = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    off += std::abs(values[i] - exact[i]) * std::sin(cases[i].theta);
    total += exact[i] * std::sin(cases[i].theta);
  }
  return 100.0 * off / total;
}

TEST_F(ShadingTest, BlinnPhongIsNearTheExactConvolution) {
  // The bounds are the rounded-up values of the table in tools/lab/fit_shading.py. The paper's equation 20 has errors
  // of 3 to 70 % for kappa <= 50.
  const struct {
    double s;
    double bound;
  } rows[] = {{5.0, 1.6}, {20.0, 0.85}, {100.0, 0.3}, {1000.0, 0.1}};
  for (const auto& row : rows)
    for (const double kappa : {0.5, 2.0, 10.0, 50.0, 1000.0, 1e4}) {
      const double spread = reference::vmf_spread(kappa);
      const double width = std::min(0.5 * std::numbers::pi, 6.0 * std::sqrt(spread + 1.0 / (row.s + 2.0)));
      const std::vector<Case> cases = angles(spread, row.s, width, 32);
      std::vector<double> exact;
      for (const Case& c : cases) exact.push_back(reference::convolved_blinn_phong(row.s, kappa, c.theta));
      const std::vector<double> product = evaluate("multum_movmf_blinn_phong(a, b.xyz, b.w)", cases);
      EXPECT_LT(relative_l1(cases, product, exact), row.bound) << "s " << row.s << " kappa " << kappa;
      if (kappa > 10.0 || row.s < 20.0) continue;
      const std::vector<double> paper = evaluate("multum_movmf_blinn_phong_paper(a, b.xyz, b.w)", cases);
      EXPECT_GT(relative_l1(cases, paper, exact), 10.0 * relative_l1(cases, product, exact));
    }
}

TEST_F(ShadingTest, LambertIsNearTheExactConvolution) {
  for (const double kappa : {0.1, 1.0, 3.0, 10.0, 50.0, 500.0}) {
    const std::vector<Case> cases = angles(reference::vmf_spread(kappa), 0.0, std::numbers::pi, 64);
    std::vector<double> exact;
    for (const Case& c : cases) exact.push_back(reference::convolved_lambert(kappa, c.theta));
    const std::vector<double> values = evaluate("multum_movmf_lambert(a, b.xyz)", cases);
    EXPECT_LT(relative_l1(cases, values, exact), 0.25) << "kappa " << kappa;
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], exact[i], 0.002);
  }
}

TEST_F(ShadingTest, LambertIsExactAtBothEnds) {
  const std::vector<Case> sharp = angles(0.0, 0.0, std::numbers::pi, 50);
  const std::vector<double> values = evaluate("multum_movmf_lambert(a, b.xyz)", sharp);
  // The length |r| = 1 is rounded, so the spread may be 1e-7 instead of 0. The result changes by the square root of the
  // spread where the cosine is 0.
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], std::max(std::cos(sharp[i].theta), 0.0), 3e-4);
  for (const double value : evaluate("multum_movmf_lambert(a, b.xyz)", angles(1.0, 0.0, std::numbers::pi, 50)))
    EXPECT_NEAR(value, 0.25, 1e-6);
}

TEST_F(ShadingTest, TorranceSparrowIsNearTheExactConvolution) {
  for (const double sigma : {0.05, 0.2, 0.6})
    for (const double kappa : {0.5, 5.0, 50.0, 2000.0}) {
      const double kappa_f = 0.5 / (sigma * sigma);
      const double spread = reference::vmf_spread(kappa);
      const double width = std::min(0.5 * std::numbers::pi, 6.0 * std::sqrt(spread + reference::vmf_spread(kappa_f)));
      const std::vector<Case> cases = angles(spread, sigma, width, 32);
      std::vector<double> exact;
      for (const Case& c : cases) exact.push_back(reference::convolved_vmf(kappa_f, kappa, c.theta));
      const std::vector<double> values = evaluate("multum_movmf_torrance_sparrow(a, b.xyz, b.w)", cases);
      // The convolution of two broad lobes of similar width is not exactly a vMF; the error is 3.2 % at sigma 0.2 and
      // kappa 5.
      EXPECT_LT(relative_l1(cases, values, exact), kappa == 5.0 ? 3.5 : 1.5) << "sigma " << sigma << " kappa " << kappa;
    }
}

TEST_F(ShadingTest, HardCases) {
  std::vector<Case> cases;
  for (const double amplitude : {0.0, 1e-8, 1.0 / 32767.0, 1.0})
    for (const double spread : {-1e-3, 0.0, 1e-7, 0.5, 1.0})  // The spread is below 0 because rounding left |r| > 1.
      for (const double theta : {0.0, 1e-4, 0.5 * std::numbers::pi, std::numbers::pi})
        for (const double s : {1.0, 100.0, 1e5}) cases.push_back({amplitude, spread, theta, s});
  for (const char* expression :
       {"multum_movmf_blinn_phong(a, b.xyz, b.w)", "multum_movmf_blinn_phong_paper(a, b.xyz, b.w)",
        "multum_movmf_lambert(a, b.xyz)", "multum_movmf_torrance_sparrow(a, b.xyz, 1.0 / sqrt(2.0 * b.w))"}) {
    const std::vector<double> values = evaluate(expression, cases);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Case& c = cases[i];
      ASSERT_TRUE(std::isfinite(values[i]) && values[i] >= 0.0)
          << expression << " = " << values[i] << ": a " << c.amplitude << " spread " << c.spread << " theta "
          << c.theta;
      if (c.amplitude < 1e-6) {
        ASSERT_EQ(values[i], 0.0) << expression;
      }
    }
  }
}

// Normals turn evenly from texel to texel, and pixels are placed at all positions between texels. On average, the lobe
// has the same spread as the normals that a pixel sees. This holds for pixels of every size up to sqrt(2) texels, even
// for pixels far smaller than one texel.
TEST_F(ShadingTest, AMagnifiedNormalMapIsAsWideAsWhatAPixelSees) {
  const int places = 64;
  const double turn = 0.2;
  for (const double width : {0.05, 0.25, 0.5, 1.0, 1.4}) {
    ShaderHarnessInput input{"multum_movmf_magnified(a, b.x)", {}, {}, nullptr};
    for (int i = 0; i < places; ++i) {
      const double t = (i + 0.5) / places;
      input.a.emplace_back(t * std::sin(turn), 0.0, 1.0 - t + t * std::cos(turn), 1.0);
      input.b.emplace_back(std::log2(width), 0.0, 0.0, 0.0);
    }
    double spread = 0.0;
    for (const glm::vec4& lobe : evaluate_shader(context_->functions(), input))
      spread += (1.0 - static_cast<double>(glm::length(glm::vec3(lobe)))) / places;
    const double half = 0.5 * turn * width;
    const double exact = 1.0 - std::sin(half) / half;
    EXPECT_NEAR(spread, exact, 0.01 * exact + 1e-6) << width;
  }
}

// Tests the weight of the normal map at each level of detail. Also tests that scaling a lobe scales its light by the
// same factor.
TEST_F(ShadingTest, TheNormalMapHasItsShare) {
  ShaderHarnessInput input{"vec4(multum_normal_map_share(b.x))", {}, {}, nullptr};
  const float lods[] = {-8.0f, -1.5f, -1.0f, -0.75f, -0.25f, 0.0f, 0.25f, 9.0f};
  const float shares[] = {1.0f, 1.0f, 1.0f, 0.75f, 0.25f, 0.0f, 0.0f, 0.0f};
  for (const float lod : lods) {
    input.a.emplace_back(0.0f);
    input.b.emplace_back(lod, 0.0f, 0.0f, 0.0f);
  }
  const std::vector<glm::vec4> values = evaluate_shader(context_->functions(), input);
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_FLOAT_EQ(values[i].x, shares[i]) << lods[i];
  // A lobe with half the amplitude reflects half the light, so lobes and normals can be mixed with weights.
  ShaderHarnessInput halves{
      "vec4(multum_movmf_blinn_phong(a, b.xyz, 50.0), 2.0 * multum_movmf_blinn_phong(0.5 * a, b.xyz, 50.0),"
      " multum_movmf_lambert(a, b.xyz), 2.0 * multum_movmf_lambert(0.5 * a, b.xyz))",
      {{0.1f, -0.2f, 0.7f, 0.8f}},
      {{0.36f, -0.48f, 0.8f, 0.0f}},
      nullptr};
  const glm::vec4 value = evaluate_shader(context_->functions(), halves)[0];
  EXPECT_NEAR(value.y, value.x, 1e-5f * value.x);
  EXPECT_NEAR(value.w, value.z, 1e-5f * value.z);
}

TEST_F(ShadingTest, EquatorialLobesLightUp) {
  // A lobe whose mean is in the plane of the surface still reflects light along it.
  ShaderHarnessInput input{"vec4(multum_movmf_lambert(a, b.xyz), multum_movmf_blinn_phong(a, b.xyz, 50.0), 0.0, 0.0)",
                           {{0.9f, 0.0f, 0.0f, 1.0f}},
                           {{1.0f, 0.0f, 0.0f, 0.0f}},
                           nullptr};
  const glm::vec4 value = evaluate_shader(context_->functions(), input)[0];
  EXPECT_NEAR(value.x, 0.9f, 0.01f);
  EXPECT_NEAR(static_cast<double>(value.y), reference::product_blinn_phong(50.0, 0.1, 0.0), 0.01);
}

}  // namespace
}  // namespace multum::gl
