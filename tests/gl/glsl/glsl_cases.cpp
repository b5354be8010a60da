// SPDX-License-Identifier: Apache-2.0
#include "tests/gl/glsl/glsl_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/lab/reference/shading.h"
#include "tests/gl/glsl/case_lists.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

}  // namespace

double highlight_cosine(const glm::dvec3& sum, const glm::dvec3& l) {
  const double size = glm::length(sum);
  return size < 1e-6 ? 0.25 : reference::mean_cosine(size, angle_between(sum / size, l));
}

SourceEdit glsl_edit(const std::string& text, const std::string& replacement) {
  return {kGlslFormulas, text, replacement};
}

SourceEdit glsl_unclamped_spread() {
  return glsl_edit("max(lobe.w - length(lobe.xyz), 0.0)", "(lobe.w - length(lobe.xyz))");
}

glm::dvec3 tilted(double degrees, double azimuth) {
  const double t = degrees * std::numbers::pi / 180.0;
  return {std::sin(t) * std::cos(azimuth), std::sin(t) * std::sin(azimuth), std::cos(t)};
}

glm::vec4 with(const glm::dvec3& v, double w) { return {glm::vec3(v), static_cast<float>(w)}; }

glm::dvec3 half_vector(const glm::dvec3& l, const glm::dvec3& v) {
  return (l + v) / std::max(glm::length(l + v), 1e-6);
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  return 2.0 * std::asin(std::min(1.0, 0.5 * glm::length(a - b)));
}

std::vector<glm::vec4> evaluate_glsl(const GlFunctions& gl, const Edits& edits, const std::string& expression,
                                     const GlslInputs& inputs, const ShaderHarnessInput& variant) {
  ShaderHarnessInput input = variant;
  input.expression = expression;
  input.edits = edits;
  for (const auto& [a, b] : inputs) {
    input.a.push_back(a);
    input.b.push_back(b);
  }
  return evaluate_shader(gl, input);
}

void compare_glsl(const GlFunctions& gl, const Edits& edits, const GlslComparison& c, WorstError& worst) {
  const std::vector<glm::vec4> values = evaluate_glsl(gl, edits, c.expression, c.inputs, c.variant);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const glm::dvec4 a(c.inputs[i].first), b(c.inputs[i].second), expected = c.exact(a, b);
    for (int k = 0; k < 4; ++k)
      worst.add(static_cast<double>(values[i][k]), expected[k], c.is_relative ? std::abs(expected[k]) : 1.0,
                fmt::format("{}[{}], a ({:.4g}, {:.4g}, {:.4g}, {:.4g}), b ({:.4g}, {:.4g}, {:.4g}, {:.4g})",
                            c.expression, k, a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w));
  }
}

const std::vector<GlslCase>& glsl_cases() {
  static const std::vector<GlslCase> cases = [] {
    std::vector<GlslCase> all;
    for (auto* part : {glsl_lobe_cases, glsl_brdf_cases, glsl_sampling_cases, glsl_filter_cases, glsl_planar_cases,
                       glsl_harmonic_cases, glsl_light_cases, glsl_surface_cases})
      for (GlslCase& c : part()) all.push_back(std::move(c));
    return all;
  }();
  return cases;
}

}  // namespace multum::gl
