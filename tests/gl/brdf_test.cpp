// SPDX-License-Identifier: Apache-2.0
// Compares the GLSL of GGX, Cook-Torrance and sums of vMFs with double precision, and checks what each shader variant
// contains.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "host/formats/brdf/vmf_terms.h"
#include "host/lab/reference/shading.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/renderer.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/gl/shader_harness.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"

namespace multum::gl {
namespace {

constexpr char kOneMinusCosine[] = "multum_one_minus_cosine(multum_movmf_mean_direction(a), b.xyz)";

class BrdfTest : public testing::Test {
 protected:
  void SetUp() override { context_ = make_test_context(test_backend()); }
  std::vector<double> evaluate(const ShaderHarnessInput& input) {
    std::vector<double> values;
    for (const glm::vec4& value : evaluate_shader(context_->functions(), input))
      values.push_back(static_cast<double>(value.x));
    return values;
  }
  std::unique_ptr<HeadlessContext> context_;
};

/// Adds a lobe along +z and directions at angles `theta` from +z; the angles are denser near 0 degrees.
void add_angles(double spread, double theta_max, int count, ShaderHarnessInput& input, std::vector<double>& angles) {
  for (int i = 0; i < count; ++i) {
    const double theta = theta_max * std::pow((i + 0.5) / count, 2.0);
    input.a.emplace_back(0.0, 0.0, 1.0 - spread, 1.0);
    input.b.emplace_back(std::sin(theta), 0.0, std::cos(theta), 0.0);
    angles.push_back(theta);
  }
}

/// Returns the relative L1 error in per cent over the hemisphere, weighted by solid angle. The angles must come from
/// add_angles().
double relative_l1(const std::vector<double>& angles, const std::vector<double>& values,
                   const std::vector<double>& exact) {
  double off = 0.0, total = 0.0;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double weight = std::sin(angles[i]) * std::sqrt(angles[i]);  // d theta = 2 sqrt(theta theta_max) du
    off += std::abs(values[i] - exact[i]) * weight;
    total += exact[i] * weight;
  }
  return 100.0 * off / total;
}

std::string terms_expression(const std::vector<VmfTerm>& terms) {
  std::string sum;
  for (const VmfTerm& term : terms)
    sum += fmt::format("{}{:.9e} * multum_term(multum_movmf_spread(a), {:.9e}, {})", sum.empty() ? "" : " + ",
                       term.weight.x, term.spread, kOneMinusCosine);
  return "vec4(" + sum + ")";
}

// The project's own bound is an error of 5 %. It applies for alpha 0.05 to 0.4, kappa 3 to 2000, and at most four
// terms.
TEST_F(BrdfTest, GgxOfFourTermsIsNearTheExactConvolution) {
  double worst[kBrdfTermCountMax] = {};
  for (const double alpha : {0.05, 0.1, 0.2, 0.3, 0.4}) {
    for (const double kappa : {3.0, 12.0, 60.0, 400.0, 2000.0}) {
      std::vector<double> angles, exact;
      ShaderHarnessInput input;
      add_angles(reference::vmf_spread(kappa), 0.5 * std::numbers::pi, 32, input, angles);
      for (const double theta : angles) exact.push_back(reference::convolved_ggx(alpha, kappa, theta));
      for (int count = 1; count <= kBrdfTermCountMax; ++count) {
        Brdf brdf;
        brdf.kind = BrdfKind::kGgx;
        brdf.roughness = static_cast<float>(std::sqrt(alpha));
        brdf.term_count = count;
        input.expression = terms_expression(vmf_terms(brdf));
        const double error = relative_l1(angles, evaluate(input), exact);
        worst[count - 1] = std::max(worst[count - 1], error);
        if (count == 4) {
          EXPECT_LT(error, 3.0) << "alpha " << alpha << " kappa " << kappa;
        }
      }
    }
  }
  std::printf("GGX, relative L1 at most: 1 term %.1f %%, 2 %.1f, 3 %.1f, 4 %.1f\n", worst[0], worst[1], worst[2],
              worst[3]);
  EXPECT_LT(worst[2], 6.0);
  EXPECT_LT(worst[1], worst[0]);
  EXPECT_LT(worst[2], worst[1]);
  EXPECT_LT(worst[3], worst[2]);
}

// Compares the errors for rougher facets, up to alpha 1, over any lobe with the figures of
// docs/contributing/ALGORITHMS.md.
TEST_F(BrdfTest, RoughGgxOfFourTermsIsWithinItsBound) {
  const std::map<double, double> bounds = {{0.05, 2.0}, {0.2, 2.5},  {0.4, 4.5},   {0.5, 6.5},
                                           {0.6, 9.0},  {0.7, 11.0}, {0.85, 15.0}, {1.0, 22.0}};
  for (const auto& [alpha, bound] : bounds) {
    Brdf brdf;
    brdf.kind = BrdfKind::kGgx;
    brdf.roughness = static_cast<float>(std::sqrt(alpha));
    brdf.term_count = kBrdfTermCountMax;
    const std::string expression = terms_expression(vmf_terms(brdf));
    double of_alpha = 0.0;
    for (const double kappa : {0.5, 1.0, 3.0, 10.0, 40.0, 200.0, 2000.0}) {
      std::vector<double> angles, exact;
      ShaderHarnessInput input;
      input.expression = expression;
      add_angles(reference::vmf_spread(kappa), 0.5 * std::numbers::pi, 32, input, angles);
      for (const double theta : angles) exact.push_back(reference::convolved_ggx(alpha, kappa, theta));
      of_alpha = std::max(of_alpha, relative_l1(angles, evaluate(input), exact));
    }
    EXPECT_LT(of_alpha, bound) << "alpha " << alpha;
    EXPECT_GT(of_alpha, 0.7 * bound) << "the documented bound is too wide, alpha " << alpha;
    std::printf("GGX of alpha %.2f, four terms, kappa 0.5 to 2000: at most %.1f %%\n", alpha, of_alpha);
  }
}

// Arguments are random or hard: narrow and broad lobes at the peak, at the horizon and at grazing angles.
TEST_F(BrdfTest, FormulasEqualTheirDoubles) {
  std::mt19937 random(20261122);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  ShaderHarnessInput input;
  for (int i = 0; i < 2000; ++i) {
    const double alpha = std::pow(10.0, -2.6 + 2.6 * unit(random));
    const double n_l = i % 5 == 0 ? std::pow(10.0, -3.0 * unit(random)) : 0.001 + 0.999 * unit(random);
    const double n_v = i % 7 == 0 ? std::pow(10.0, -3.0 * unit(random)) : 0.001 + 0.999 * unit(random);
    const double e = i % 3 == 0 ? alpha * alpha * std::pow(10.0, 4.0 * unit(random) - 3.0) : unit(random);
    input.a.emplace_back(alpha, n_l, n_v, std::min(e, 0.9999));
    input.b.emplace_back(unit(random), 0.02 + 0.98 * unit(random), 0.0, 0.0);  // n_h or F0, v_h
  }
  const auto d = [](float x) { return static_cast<double>(x); };
  const auto expect = [&](const std::string& expression, const std::function<double(std::size_t)>& exact,
                          double bound) {
    input.expression = "vec4(" + expression + ")";
    const std::vector<double> values = evaluate(input);
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_NEAR(values[i] / exact(i), 1.0, bound)
          << expression << " a " << input.a[i].x << " " << input.a[i].y << " " << input.a[i].z << " " << input.a[i].w;
  };
  // The denominator is a sum of squares in single precision, and all of its terms are positive.
  expect(
      "multum_ggx(a.x, a.w)",
      [&](std::size_t i) {
        const double theta = 2.0 * std::asin(std::sqrt(0.5 * d(input.a[i].w)));
        return reference::ggx(d(input.a[i].x), theta);
      },
      3e-6);
  expect(
      "multum_smith_visibility(a.x, a.y, a.z)",
      [&](std::size_t i) { return reference::smith_visibility(d(input.a[i].x), d(input.a[i].y), d(input.a[i].z)); },
      2e-5);
  expect(
      "multum_groove_visibility(a.y, a.z, b.x, b.y)",
      [&](std::size_t i) {
        return reference::groove_visibility(d(input.a[i].y), d(input.a[i].z), d(input.b[i].x), d(input.b[i].y));
      },
      2e-6);
  expect(
      "multum_schlick(vec3(b.x), b.y).x",
      [&](std::size_t i) { return reference::schlick(d(input.b[i].x), d(input.b[i].y)); }, 2e-6);
}

TEST_F(BrdfTest, HardCases) {
  ShaderHarnessInput input;
  for (const float x : {0.0f, 1e-30f, 1e-6f, 1e-3f, 0.5f, 1.0f})
    for (const float y : {0.0f, 1e-30f, 1e-6f, 1e-3f, 0.5f, 1.0f})
      for (const float alpha : {0.0025f, 0.1f, 1.0f}) {
        input.a.emplace_back(0.0f, 0.0f, 1.0f - x, 1.0f);
        input.b.emplace_back(x, y, alpha, 0.0f);
      }
  for (const char* expression :
       {"multum_smith_visibility(b.z, b.x, b.y) * b.x", "multum_groove_visibility(b.x, b.y, 1.0, 1.0) * b.x",
        "multum_groove_visibility(b.x, b.y, 0.0, 0.0) * b.x", "multum_ggx(b.z, b.x)",
        "multum_term(multum_movmf_spread(a), b.z * b.z, b.y)", "multum_schlick(vec3(b.x), b.y).x"}) {
    input.expression = std::string("vec4(") + expression + ")";
    for (const double value : evaluate(input)) ASSERT_TRUE(std::isfinite(value) && value >= 0.0) << expression;
  }
}

/// Returns whether one of the texts contains `word`, which is a flag or the beginning of a definition.
bool holds(const ShaderSources& sources, const std::string& word) {
  for (const std::string& text : sources.fragment)
    if (text.find("\n" + word) != std::string::npos) return true;
  return std::find(sources.flags.begin(), sources.flags.end(), word) != sources.flags.end();
}

// Each row of the table names files in the folder brdf/, and every file there belongs to a row.
TEST_F(BrdfTest, RowsNameTheShadersThatThereAre) {
  std::set<std::string> named;
  for (const BrdfFamily& family : brdf_families())
    for (const std::string_view file : family.shader_files) named.emplace(file);
  std::set<std::string> there;
  for (const auto& [file, text] : brdf_shaders()) there.insert(file);
  EXPECT_EQ(named, there);
}

TEST_F(BrdfTest, AVariantHoldsWhatItNeeds) {
  const TestMap map = make_flat_map(4);
  const MovmfMaterial lobes(context_->functions(), map.mipmap, 1.0f);
  const NormalMaterial reference(context_->functions(), map.image, NormalMaterial::Sampling::kNearest, 1.0f);
  RenderScene scene;
  const ShaderSources phong = scene_shader_sources(lobes, scene);
  for (const char* word :
       {"float multum_movmf_blinn_phong(", "MULTUM_DIRECTIONAL_LIGHTS 1", "uniform sampler2D u_lobes"})
    EXPECT_TRUE(holds(phong, word)) << word;
  for (const char* word :
       {"float multum_movmf_torrance_sparrow(", "float multum_ggx(", "float multum_term(", "MULTUM_POINT_LIGHTS 1",
        "float multum_moments_lean(", "uniform sampler2D u_normals", "vec3 multum_irradiance(", "vec3 multum_schlick("})
    EXPECT_FALSE(holds(phong, word)) << word;
  EXPECT_FALSE(holds(scene_shader_sources(reference, scene), "uniform sampler2D u_lobes"));
  scene.brdf.kind = BrdfKind::kLambert;
  scene.lights.clear();
  scene.point_lights.emplace_back();
  const ShaderSources lambert = scene_shader_sources(lobes, scene);
  EXPECT_TRUE(holds(lambert, "MULTUM_POINT_LIGHTS 1"));
  EXPECT_FALSE(holds(lambert, "MULTUM_DIRECTIONAL_LIGHTS 1"));
  EXPECT_FALSE(holds(lambert, "float multum_movmf_blinn_phong("));
  scene.brdf.kind = BrdfKind::kGgx;
  const ShaderSources ggx = scene_shader_sources(lobes, scene);
  EXPECT_TRUE(holds(ggx, "vec4 multum_ggx_lobe_shape("));
  EXPECT_FALSE(holds(ggx, "float multum_term("));
  EXPECT_TRUE(holds(ggx, "float multum_smith_visibility("));
  EXPECT_FALSE(holds(ggx, "float multum_movmf_torrance_sparrow("));
}

}  // namespace
}  // namespace multum::gl
