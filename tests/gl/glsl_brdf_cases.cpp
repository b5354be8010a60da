// SPDX-License-Identifier: Apache-2.0
#include "tests/gl/glsl_brdf_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/reference/shading.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

SourceEdit edit(const std::string& text, const std::string& replacement) {
  return {"movmf_shading", text, replacement};  // what the harness calls all of common/ and brdf/
}

// An expression of b.x and b.y over pairs of numbers, against `exact` of them as floats; errors over `scale`.
struct Comparison {
  std::string expression;
  std::vector<std::pair<double, double>> inputs;
  std::function<double(double, double)> exact;
  bool is_relative;
};

void compare(const GlFunctions& gl, const Edits& edits, const Comparison& c, WorstError& worst) {
  ShaderHarnessInput input{"vec4(" + c.expression + ")", {}, {}, nullptr, edits};
  for (const auto& [x, y] : c.inputs) {
    input.a.emplace_back(0.0f, 0.0f, 1.0f, 1.0f);
    input.b.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0f, 0.0f);
  }
  const std::vector<glm::vec4> values = evaluate_shader(gl, input);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = static_cast<double>(input.b[i].x), y = static_cast<double>(input.b[i].y);
    const double expected = c.exact(x, y);
    worst.add(static_cast<double>(values[i].x), expected, c.is_relative ? std::abs(expected) : 1.0,
              fmt::format("{:.4g}, {:.4g}", x, y));
  }
}

std::vector<std::pair<double, double>> grid(const std::vector<double>& xs, const std::vector<double>& ys) {
  std::vector<std::pair<double, double>> pairs;
  for (const double x : xs)
    for (const double y : ys) pairs.emplace_back(x, y);
  return pairs;
}

const std::vector<double> kCosines = {0.0, 1e-30, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 1.0};

void ggx_peak(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const std::vector<double> alphas = {0.0025, 0.01, 0.1, 0.4, 1.0};
  const std::vector<double> ones = {0.0, 1e-9, 1e-7, 3.3e-6, 1e-4, 0.01, 0.3, 0.999};
  const auto exact = [](double alpha, double e) { return reference::ggx(alpha, 2.0 * std::asin(std::sqrt(0.5 * e))); };
  compare(gl, edits, {"multum_ggx(b.x, b.y)", grid(alphas, ones), exact, true}, worst);
}

// V n.l, which is what is used: 0 where n.l is, however near 0 n.v is too.
void smith_grazing(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const auto exact = [](double n_l, double n_v) {
    if (n_l == 0.0) return 0.0;
    const double x = static_cast<double>(0.1f) * static_cast<double>(0.1f);
    const double sum = n_l * std::sqrt(n_v * n_v * (1.0 - x) + x) + n_v * std::sqrt(n_l * n_l * (1.0 - x) + x);
    return 0.5 * n_l / std::max(sum, 1e-6);
  };
  compare(gl, edits, {"multum_smith_visibility(0.1, b.x, b.y) * b.x", grid(kCosines, kCosines), exact, false}, worst);
}

void groove_grazing(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const auto exact = [](double n_l, double n_v) {
    const double whole = 1.0 / std::max(n_l * n_v, 1e-8), groove = 2.0 / std::max({n_l, n_v, 1e-4});
    return 0.25 * n_l * std::min(whole, groove);
  };
  compare(gl, edits, {"multum_groove_visibility(b.x, b.y, 1.0, 1.0) * b.x", grid(kCosines, kCosines), exact, false},
          worst);
}

double exact_zonal(double kappa, int order) {
  double quotient = kappa / (order + 60.5 + std::sqrt((order + 60.5) * (order + 60.5) + kappa * kappa));
  double value = 1.0;
  for (int l = order + 59; l >= 1; --l) {
    quotient = kappa / (2.0 * l + 1.0 + kappa * quotient);
    if (l <= order) value *= quotient;
  }
  return value;
}

void second_zonal(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const auto exact = [](double r, double) { return r == 0.0 ? 0.0 : exact_zonal(reference::vmf_kappa(1.0 - r), 2); };
  compare(gl, edits,
          {"multum_vmf_second_zonal(b.x, multum_vmf_kappa(1.0 - b.x))",
           grid({0.0, 1e-6, 1e-3, 0.05, 0.1, 0.11, 0.3, 0.7, 0.95, 0.999}, {0.0}), exact, false},
          worst);
}

void eighth_zonal(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const auto exact = [](double kappa, double) { return exact_zonal(kappa, 8); };
  compare(gl, edits,
          {"multum_vmf_eighth_zonal(b.x)", grid({0.0, 1e-3, 0.5, 3.0, 20.0, 100.0, 1e3, 1e4, 1e5, 1e6}, {0.0}), exact,
           false},
          worst);
}

}  // namespace

std::vector<GlslCase> glsl_brdf_cases() {
  return {
      {{"glsl-ggx-at-its-peak", "ggx.glsl", "1 - t^2 (1 - alpha^2) cancels near t = 1: per cent off at roughness 0.05",
        "alpha^2 t^2 + e (2 - e), e = 1 - t: a sum of what is small", 5e-6, "relative", "two squares of float"},
       {edit("x * t * t + e * (2.0 - e)", "1.0 - t * t * (1.0 - x)")},
       ggx_peak},
      {{"glsl-smith-at-grazing-angles", "ggx.glsl", "both cosines 0: 0.5 / 0, and inf times the cosine",
        "the denominator is at least 1e-6", 2e-6, "absolute", "a root and four products of float"},
       {edit("0.5 / max(masking + shadowing, 1e-6)", "0.5 / (masking + shadowing)")},
       smith_grazing},
      {{"glsl-grooves-at-grazing-angles", "cook_torrance.glsl", "a cosine of 0 is divided by: inf times 0",
        "quotients of the cosines' product and of the larger of them, both held from 0", 2e-6, "absolute",
        "three products of float"},
       {edit("max(n_l * n_v, 1e-8)", "(n_l * n_v)"), edit("max(max(n_l, n_v), 1e-4)", "max(n_l, n_v)")},
       groove_grazing},
      {{"glsl-second-zonal-of-broad-lobes", "vmf_zonal.glsl", "1 - 3 |r| / kappa cancels, and is 0 / 0 at r = 0",
        "3/5 r^2 below r = 0.1", 5e-4, "absolute", "2.3e-4 of kappa's inverse"},
       {edit("r > 0.1 ?", "r > -1.0 ?")},
       second_zonal},
      {{"glsl-eighth-zonal-of-every-kappa", "vmf_zonal.glsl", "the recurrence started from 0 fails for large kappa",
        "started twelve orders above from the asymptotic quotient", 1e-4, "absolute",
        "twelve orders leave 2.6e-5 at kappa 100"},
       {edit("float quotient = kappa / (middle + sqrt(middle * middle + kappa * kappa));", "float quotient = 0.0;")},
       eighth_zonal},
  };
}

}  // namespace multum::gl
