// SPDX-License-Identifier: Apache-2.0
// Defines the numerical cases of brdf/ and vmf_zonal.glsl. The facets are at their peak, at grazing angles, and facing
// away.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/vec3.hpp>

#include "host/formats/brdf/ggx_lobe.h"
#include "host/formats/brdf/ggx_lobe_specular.h"
#include "host/lab/reference/charlie.h"
#include "host/lab/reference/shading.h"
#include "runtime_gl/materials/ggx_lobe_texture.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/gl/glsl/case_lists.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

// Compares an expression of b.x and b.y with `exact` for pairs of floats.
struct PairComparison {
  std::string expression;
  std::vector<std::pair<double, double>> inputs;
  std::function<double(double, double)> exact;
  bool is_relative;
};

void compare(const GlFunctions& gl, const Edits& edits, const PairComparison& c, WorstError& worst) {
  GlslComparison comparison{"vec4(" + c.expression + ")", {}, {}, c.is_relative};
  for (const auto& [x, y] : c.inputs)
    comparison.inputs.push_back({{}, {static_cast<float>(x), static_cast<float>(y), 0.0f, 0.0f}});
  comparison.exact = [&](const glm::dvec4&, const glm::dvec4& b) { return glm::dvec4(c.exact(b.x, b.y)); };
  compare_glsl(gl, edits, comparison, worst);
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

// Tests `V n.l`, which the shader uses. If n.l is 0, the product is 0, even if n.v is also nearly 0.
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

void second_zonal(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const auto exact = [](double r, double) {
    return r == 0.0 ? 0.0 : reference::zonal_of_vmf(reference::vmf_kappa(1.0 - r), 2);
  };
  compare(gl, edits,
          {"multum_vmf_second_zonal(b.x, multum_vmf_kappa(1.0 - b.x))",
           grid({0.0, 1e-6, 1e-3, 0.05, 0.1, 0.11, 0.3, 0.7, 0.95, 0.999}, {0.0}), exact, false},
          worst);
}

void eighth_zonal(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const auto exact = [](double kappa, double) { return reference::zonal_of_vmf(kappa, 8); };
  compare(gl, edits,
          {"multum_vmf_eighth_zonal(b.x)", grid({0.0, 1e-3, 0.5, 3.0, 20.0, 100.0, 1e3, 1e4, 1e5, 1e6}, {0.0}), exact,
           false},
          worst);
}

// Tests 1 - v.h outside the range 0 to 1, for cosines that rounding left above 1 and for views from below.
void schlick_ends(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  compare(gl, edits,
          {"multum_schlick(vec3(b.x), b.y).x", grid({0.0, 0.04, 1.0}, {-1.0, -1e-6, 0.0, 1e-6, 0.5, 1.0, 1.0001, 2.0}),
           [](double f0, double v_h) { return reference::schlick(f0, std::clamp(v_h, 0.0, 1.0)); }, false},
          worst);
}

// Tests a term whose d, q and e are in a.xyz. Compares the peak, and the value as a fraction of the peak.
void terms_of_every_spread(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{
      "vec4(multum_term(a.x, a.y, a.z) / multum_term(a.x, a.y, 0.0), multum_term(a.x, a.y, 0.0) * a.w, 0.0, "
      "0.0)",
      {},
      {}};
  const auto kappa_of = [](double d, double q) { return reference::vmf_kappa(d + (1.0 - d) * q); };
  for (const float d : {0.0f, 1e-6f, 0.01f, 0.5f, 1.0f})
    for (const float q : {1e-5f, 1e-3f, 0.1f, 0.9f})
      for (const float e : {0.0f, 1e-6f, 0.1f, 1.0f, 2.0f}) {
        const double peak = reference::vmf_density(kappa_of(static_cast<double>(d), static_cast<double>(q)), 0.0);
        c.inputs.push_back({{d, q, e, static_cast<float>(1.0 / peak)}, {}});
      }
  c.exact = [=](const glm::dvec4& a, const glm::dvec4&) {
    return glm::dvec4(std::exp(-kappa_of(a.x, a.y) * a.z), 1.0, 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

double nothing(double) { return 0.0; }

// Describes the shader functions of one BRDF: V, F, f of a single normal, and f of a lobe, all relative to the peak of
// f. `flags` select the BRDF.
struct FacetsOf {
  std::vector<std::string> flags;
  std::string visibility, fresnel;  // expressions that contain the cosine c = b.w
  double peak;
  std::function<double(double theta)> facets = {};
  std::function<double(double spread, double theta)> lobe_facets = {};
  std::function<double(double cosine)> exact_visibility = nothing, exact_fresnel = nothing;
  std::function<void(const ShaderProgram&)> set_uniforms = {};
  std::string formulas = {};
};

const glm::vec4 kHardLobes[] = {{0.0f, 0.0f, 1.0f, 1.0f}, {0.0f, 0.0f, 1.0001f, 1.0f}, {0.0f, 0.0f, 0.45f, 0.5f},
                                {0.0f, 0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 1e-9f, 1e-8f},  {0.0f, 0.0f, 0.0f, 0.0f}};

void compare_facets(const GlFunctions& gl, const Edits& edits, const FacetsOf& f, WorstError& worst) {
  GlslComparison c;
  c.expression = fmt::format(
      "vec4(multum_facets(vec3(0.0, 0.0, 1.0), b.xyz).x / u_facet_total.x, multum_lobe_facets(a, b.xyz).x / "
      "u_facet_total.x, {}, {})",
      f.visibility, f.fresnel);
  for (const glm::vec4& lobe : kHardLobes)
    for (const double theta : {0.0, 1e-4, 0.1, 0.5, 1.0, 1.57, 1.58, 2.5, M_PI})
      for (const float cosine : {0.05f, 0.5f, 1.0f})
        c.inputs.push_back({lobe, {glm::vec3(std::sin(theta), 0.0, std::cos(theta)), cosine}});
  c.exact = [&](const glm::dvec4& a, const glm::dvec4& b) {
    const double theta = angle_between(glm::dvec3(b), {0.0, 0.0, 1.0}),
                 spread = std::clamp((a.w - a.z) / std::max(a.w, 1e-6), 0.0, 1.0);
    const double of_lobe = a.w <= 1e-6 ? 0.0 : a.w * f.lobe_facets(spread, theta);
    return glm::dvec4(f.facets(theta) / f.peak, of_lobe / f.peak, f.exact_visibility(b.w), f.exact_fresnel(b.w));
  };
  c.variant.flags = f.flags;
  c.variant.formulas = f.formulas;
  c.variant.set_uniforms = [&](const ShaderProgram& program) {
    const glm::vec3 peak(static_cast<float>(f.peak));
    program.set_vec3("u_facet_total", &peak.x, 1);
    f.set_uniforms(program);
  };
  compare_glsl(gl, edits, c, worst);
}

void blinn_phong_facets(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const double s : {5.0, 1e4}) {
    FacetsOf f{{"MULTUM_BLINN_PHONG"}, "0.0", "0.0", (s + 1.0) / (2.0 * M_PI)};
    f.facets = [=](double theta) { return reference::blinn_phong(s, theta); };
    f.lobe_facets = [=](double spread, double theta) { return reference::product_blinn_phong(s, spread, theta); };
    f.set_uniforms = [=](const ShaderProgram& program) { program.set("u_exponent", static_cast<float>(s)); };
    compare_facets(gl, edits, f, worst);
  }
}

void cook_torrance_facets(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const float sigma : {0.02f, 0.5f}) {
    const double kappa = 0.5 / (static_cast<double>(sigma) * static_cast<double>(sigma));
    FacetsOf f{{"MULTUM_TORRANCE_SPARROW", "MULTUM_COOK_TORRANCE", "MULTUM_FRESNEL_DIFFUSE"},
               "multum_visibility(b.w, 0.7, 0.9, 0.8)",
               "multum_fresnel(b.w).x",
               reference::vmf_density(kappa, 0.0)};
    f.facets = [=](double theta) { return reference::vmf_density(kappa, theta); };
    f.lobe_facets = [=](double spread, double theta) {
      const double q = spread + (1.0 - spread) * reference::vmf_spread(kappa);
      return reference::vmf_density(reference::vmf_kappa(q), theta);
    };
    f.exact_visibility = [](double n_l) { return reference::groove_visibility(n_l, 0.7, 0.9, 0.8); };
    f.exact_fresnel = [](double v_h) { return reference::schlick(0.25, v_h); };
    f.set_uniforms = [=](const ShaderProgram& program) {
      const glm::vec3 f0(0.25f);
      program.set("u_sigma", sigma);
      program.set_vec3("u_f0", glm::value_ptr(f0), 1);
    };
    compare_facets(gl, edits, f, worst);
  }
}

// Tests two terms, one of which has a negative weight. Far from the peak, the negative term is larger than the positive
// term.
void facets_of_terms(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const glm::vec3 weights[] = {glm::vec3(1.5f), glm::vec3(-0.5f)};
  const float spreads[] = {0.01f, 0.3f};
  FacetsOf f{{"MULTUM_MEASURED", "MULTUM_TERM_COUNT 2"}, "0.0", "0.0", 20.0};
  f.formulas = brdf_shader_text("measured.glsl");  // the shader's table stays black here
  f.facets = nothing;
  f.lobe_facets = [=](double spread, double theta) {
    double sum = 0.0;
    for (int i = 0; i < 2; ++i) {
      const double q = spread + (1.0 - spread) * static_cast<double>(spreads[i]);
      sum += static_cast<double>(weights[i].x) * reference::vmf_density(reference::vmf_kappa(q), theta);
    }
    return std::max(sum, 0.0);
  };
  f.set_uniforms = [=](const ShaderProgram& program) {
    program.set_vec3("u_term_weights", glm::value_ptr(weights[0]), 2);
    program.set_floats("u_term_spreads", spreads, 2);
  };
  compare_facets(gl, edits, f, worst);
}

void ggx_facets(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const Texture table = make_ggx_lobe_texture(gl);
  for (const float alpha : {0.01f, 0.4f, 1.0f}) {
    const auto a = static_cast<double>(alpha);
    FacetsOf f{{"MULTUM_GGX"}, "multum_visibility(b.w, 0.7, 0.9, 0.8)", "0.0", reference::ggx(a, 0.0)};
    f.formulas = brdf_shader_text("ggx_lobe.glsl");
    f.facets = [=](double theta) { return theta < 0.5 * M_PI ? reference::ggx(a, theta) : 0.0; };
    f.lobe_facets = [=](double spread, double theta) {
      return ggx_lobe_density(ggx_lobe_shape(a, spread), a, spread, 1.0 - std::cos(theta));
    };
    f.exact_visibility = [=](double n_l) { return reference::smith_visibility(a, n_l, 0.7); };
    f.set_uniforms = [&](const ShaderProgram& program) {
      program.set("u_alpha", alpha);
      program.set("u_ggx_lobe_table", 3);
      table.bind(3);
    };
    compare_facets(gl, edits, f, worst);
  }
}

double ggx_facet_kappa(double alpha, double kappa, double e) {
  double facets = 2.0 / (alpha * alpha);
  for (int step = 0; step < 2; ++step) {
    const double sum = facets + kappa, size = std::sqrt(std::max(sum * sum - 2.0 * facets * kappa * e, 1e-12));
    const double beside = 2.0 * kappa * e * (size + kappa - facets) / (size * (size + sum));
    facets = 4.0 / ((1.0 + 0.5 * alpha) * (alpha * alpha + beside + 3.0 / sum));
  }
  return facets;
}

// Tests a lobe that is opposite to h and as sharp as the facets, so that the lobe and the facets cancel each other.
void facet_kappa_of_opposite_lobes(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_ggx_facet_kappa(a.x, a.y, a.z) / b.x, 0.0, 0.0, 0.0)", {}, {}};
  for (const float alpha : {0.0025f, 0.5f, 1.0f})
    for (const float kappa : {0.0f, 2.0f, 8.0f, 1e4f})
      for (const float e : {0.0f, 1e-6f, 0.5f, 1.0f, 2.0f}) {
        const double value =
            ggx_facet_kappa(static_cast<double>(alpha), static_cast<double>(kappa), static_cast<double>(e));
        c.inputs.push_back({{alpha, kappa, e, 0.0f}, {static_cast<float>(value), 0.0f, 0.0f, 0.0f}});
      }
  c.exact = [](const glm::dvec4&, const glm::dvec4&) { return glm::dvec4(1.0, 0.0, 0.0, 0.0); };
  c.variant.formulas = brdf_shader_text("ggx_lobe.glsl");
  compare_glsl(gl, edits, c, worst);
}

// Describes the highlight of difficult lobes, which is the mean of f(n . h) max(n . l, 0) over each lobe. Each term of
// f has its own cosine.
struct HighlightOf {
  std::vector<std::string> flags;
  std::vector<glm::dvec2> terms;                                   // weight and kappa of each term
  std::function<double(double spread, double theta)> lobe_facets;  // used for a single term with its own formula
  std::function<void(const ShaderProgram&)> set_uniforms;
};

void compare_highlight(const GlFunctions& gl, const Edits& edits, const HighlightOf& f, double peak,
                       WorstError& worst) {
  const glm::dvec3 l = glm::normalize(glm::dvec3(0.6, 0.3, 0.8)), up(0.0, 0.0, 1.0);
  GlslComparison c;
  c.expression =
      fmt::format("vec4(multum_lobe_highlight(a, b.xyz, vec3({}, {}, {})).x / u_facet_total.x)", l.x, l.y, l.z);
  for (const glm::vec4& lobe : kHardLobes)
    for (const double theta : {0.0, 1e-4, 0.1, 0.5, 1.0, 1.57, 1.58, 2.5})
      c.inputs.push_back({lobe, {glm::vec3(std::sin(theta), 0.0, std::cos(theta)), 0.0f}});
  c.exact = [=](const glm::dvec4& a, const glm::dvec4& b) {
    if (a.w <= 1e-6) return glm::dvec4(0.0);
    const double theta = angle_between(glm::dvec3(b), up), spread = std::clamp((a.w - a.z) / a.w, 0.0, 1.0);
    const double kappa = spread == 0.0 ? 1e12 : spread == 1.0 ? 0.0 : reference::vmf_kappa(spread);
    double sum = 0.0;
    for (const glm::dvec2& term : f.terms) {
      const double q = spread + (1.0 - spread) * reference::vmf_spread(term.y);
      const double facets = f.lobe_facets ? f.lobe_facets(spread, theta)
                                          : term.x * reference::vmf_density(reference::vmf_kappa(q), theta);
      sum += facets * highlight_cosine(term.y * glm::dvec3(b) + kappa * up, l);
    }
    return glm::dvec4(a.w * std::max(sum, 0.0) / peak);
  };
  c.variant.flags = f.flags;
  c.variant.set_uniforms = [=](const ShaderProgram& program) {
    const glm::vec3 total(static_cast<float>(peak));
    program.set_vec3("u_facet_total", &total.x, 1);
    f.set_uniforms(program);
  };
  compare_glsl(gl, edits, c, worst);
}

void highlights_of_hard_lobes(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const double s : {5.0, 1e4})
    compare_highlight(gl, edits,
                      {{"MULTUM_BLINN_PHONG"},
                       {{1.0, reference::vmf_kappa(1.0 / (s + 2.0))}},
                       [=](double spread, double theta) { return reference::product_blinn_phong(s, spread, theta); },
                       [=](const ShaderProgram& program) { program.set("u_exponent", static_cast<float>(s)); }},
                      (s + 1.0) / (2.0 * M_PI), worst);
  const double sigma = 0.25, kappa = 0.5 / (sigma * sigma);
  compare_highlight(gl, edits,
                    {{"MULTUM_TORRANCE_SPARROW"},
                     {{1.0, kappa}},
                     {},
                     [=](const ShaderProgram& program) { program.set("u_sigma", static_cast<float>(sigma)); }},
                    reference::vmf_density(kappa, 0.0), worst);
  const glm::vec3 weights[] = {glm::vec3(1.5f), glm::vec3(-0.5f)};
  const float spreads[] = {0.01f, 0.3f};
  compare_highlight(gl, edits,
                    {{"MULTUM_TERM_COUNT 2"},
                     {{1.5, reference::vmf_kappa(static_cast<double>(spreads[0]))},
                      {-0.5, reference::vmf_kappa(static_cast<double>(spreads[1]))}},
                     {},
                     [=](const ShaderProgram& program) {
                       program.set_vec3("u_term_weights", glm::value_ptr(weights[0]), 2);
                       program.set_floats("u_term_spreads", spreads, 2);
                     }},
                    20.0, worst);
}

void ggx_highlights(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const Texture table = make_ggx_lobe_texture(gl);
  const glm::dvec3 l = glm::normalize(glm::dvec3(0.6, 0.3, 0.8)), up(0.0, 0.0, 1.0);
  for (const float alpha : {0.01f, 0.4f, 1.0f}) {
    const auto alpha_double = static_cast<double>(alpha);
    GlslComparison c;
    const std::string direction = fmt::format("vec3({}, {}, {})", l.x, l.y, l.z);
    c.expression = fmt::format(
        "vec4(multum_lobe_highlight(a, b.xyz, {}).x, multum_movmf_ggx_specular(u_ggx_lobe_table, a, {}, vec3(0.0, 0.6, "
        "0.8), b.xyz, u_alpha), 0.0, 0.0) * (MULTUM_PI * {})",
        direction, direction, alpha_double * alpha_double);
    for (const glm::vec4& lobe : kHardLobes)
      for (const double theta : {0.0, 1e-4, 0.1, 0.5, 1.0, 1.57, 1.58, 2.5})
        c.inputs.push_back({lobe, {glm::vec3(std::sin(theta), 0.0, std::cos(theta)), 0.0f}});
    c.exact = [=](const glm::dvec4& a, const glm::dvec4& b) {
      if (a.w <= 1e-6) return glm::dvec4(0.0);
      const double e = 1.0 - std::cos(angle_between(glm::dvec3(b), up)),
                   spread = std::clamp((a.w - a.z) / a.w, 0.0, 1.0);
      const double kappa = spread == 0.0 ? 1e12 : spread == 1.0 ? 0.0 : reference::vmf_kappa(spread);
      const double facets = ggx_lobe_density(ggx_lobe_shape(alpha_double, spread), alpha_double, spread, e);
      const glm::dvec3 sum = ggx_facet_kappa(alpha_double, kappa, e) * glm::dvec3(b) + kappa * up;
      const double unit = M_PI * alpha_double * alpha_double;
      const double specular = GgxOverLobe(a, alpha_double).specular(l, {0.0, 0.6, 0.8}, glm::dvec3(b));
      return glm::dvec4(a.w * facets * highlight_cosine(sum, l) * unit, specular * unit, 0.0, 0.0);
    };
    c.variant.flags = {"MULTUM_GGX"};
    c.variant.formulas = brdf_shader_text("ggx_lobe.glsl");
    c.variant.set_uniforms = [&](const ShaderProgram& program) {
      program.set("u_alpha", alpha);
      program.set("u_ggx_lobe_table", 3);
      table.bind(3);
    };
    compare_glsl(gl, edits, c, worst);
  }
}

// Contains the mean and variance of n . h over a lobe of amplitude 1, as in brdf/charlie.glsl.
struct LobeProjection {
  double mean, variance;
};

double kappa_of_spread(double spread) {
  return spread == 0.0 ? 1e12 : spread == 1.0 ? 0.0 : reference::vmf_kappa(spread);
}

LobeProjection lobe_projection(double spread, double theta) {
  const double r = 1.0 - spread, t = std::cos(theta), across = r > 1e-3 ? r / kappa_of_spread(spread) : 1.0 / 3.0;
  const double along = std::max(1.0 - r * r - 2.0 * across, 0.0);
  return {r * t, across + (along - across) * t * t};
}

double charlie_over_lobe(double p, double spread, double theta) {
  const double r = 1.0 - spread, w = r > 0.1 ? std::min(3.0 * r / kappa_of_spread(spread), 1.0) : 1.0 - 0.6 * r * r;
  const double wide = 3.0 * (1.0 - w) * p / (3.0 + 2.0 * p * w);
  const LobeProjection n_h = lobe_projection(spread, theta);
  const double x =
      std::clamp(n_h.mean / std::sqrt(std::max(n_h.variance * (1.0 + 2.0 * p * n_h.variance), 1e-12)), -8.0, 8.0);
  return (1.0 + p) / M_PI * std::sqrt((wide + 0.7854) / (p + 0.7854)) *
         std::pow(std::max(std::pow(std::sin(theta), 2.0), 1e-30), wide) * 0.5 * std::erfc(-x / std::sqrt(2.0));
}

double charlie_facet_kappa(double p, double spread, double theta) {
  const LobeProjection n_h = lobe_projection(spread, theta);
  return -2.0 * p * n_h.mean / (1.0 + 2.0 * p * n_h.variance);
}

void charlie_facets(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const float alpha : {0.0025f, 0.25f, 1.0f}) {
    const auto a = static_cast<double>(alpha);
    FacetsOf f{{"MULTUM_CHARLIE"}, "multum_visibility(b.w, 0.7, 0.9, 0.8)", "0.0", reference::charlie(a, 1.57)};
    f.formulas = brdf_shader_text("charlie.glsl");
    f.facets = [=](double theta) { return reference::charlie(a, theta); };
    f.lobe_facets = [=](double spread, double theta) { return charlie_over_lobe(0.5 / a, spread, theta); };
    f.exact_visibility = [](double n_l) { return reference::sheen_visibility(n_l, 0.7); };
    f.set_uniforms = [=](const ShaderProgram& program) { program.set("u_alpha", alpha); };
    compare_facets(gl, edits, f, worst);
  }
}

// Tests pairs of cosines in which both, one or neither is 0.
void sheen_grazing(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_sheen_visibility(a.x, a.y) * a.x, 0.0, 0.0, 0.0)", {}, {}};
  for (const float n_l : {0.0f, 1e-6f, 1e-3f, 0.5f, 1.0f})
    for (const float n_v : {0.0f, 1e-6f, 1e-3f, 0.5f, 1.0f}) c.inputs.push_back({{n_l, n_v, 0.0f, 0.0f}, {}});
  c.exact = [](const glm::dvec4& a, const glm::dvec4&) {
    return glm::dvec4(a.x > 0.0 ? a.x * reference::sheen_visibility(a.x, a.y) : 0.0, 0.0, 0.0, 0.0);
  };
  c.variant.formulas = brdf_shader_text("charlie.glsl");
  compare_glsl(gl, edits, c, worst);
}

void charlie_highlights(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const glm::dvec3 l = glm::normalize(glm::dvec3(0.6, 0.3, 0.8)), up(0.0, 0.0, 1.0);
  for (const float alpha : {0.0025f, 0.25f, 1.0f}) {
    const double p = 0.5 / static_cast<double>(alpha);
    GlslComparison c;
    c.expression = fmt::format("vec4(multum_lobe_highlight(a, b.xyz, vec3({}, {}, {})).x) * {:.9e}", l.x, l.y, l.z,
                               M_PI / (1.0 + p));
    for (const glm::vec4& lobe : kHardLobes)
      for (const double theta : {0.0, 1e-4, 0.1, 0.5, 1.0, 1.57, 1.58, 2.5})
        c.inputs.push_back({lobe, {glm::vec3(std::sin(theta), 0.0, std::cos(theta)), 0.0f}});
    c.exact = [=](const glm::dvec4& a, const glm::dvec4& b) {
      if (a.w <= 1e-6) return glm::dvec4(0.0);
      const double theta = angle_between(glm::dvec3(b), up), spread = std::clamp((a.w - a.z) / a.w, 0.0, 1.0);
      const glm::dvec3 sum = charlie_facet_kappa(p, spread, theta) * glm::dvec3(b) + kappa_of_spread(spread) * up;
      return glm::dvec4(a.w * charlie_over_lobe(p, spread, theta) * highlight_cosine(sum, l) * M_PI / (1.0 + p));
    };
    c.variant.flags = {"MULTUM_CHARLIE"};
    c.variant.formulas = brdf_shader_text("charlie.glsl");
    c.variant.set_uniforms = [=](const ShaderProgram& program) { program.set("u_alpha", alpha); };
    compare_glsl(gl, edits, c, worst);
  }
}

// Each table entry contains its own index, so each value that the shader reads is the index that it used.
void measured_tables(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr int kFacets = 90, kDifferences = 19;
  GlslComparison c{"vec4(multum_facets(vec3(0.0, 0.0, 1.0), b.xyz).x, multum_fresnel(b.w).x, 0.0, 0.0)", {}, {}};
  for (const double theta : {0.0, 1e-6, 1e-3, 0.3, 1.0, 1.57, 1.58, 2.5, M_PI})
    for (const float cosine : {-1e-3f, 0.0f, 1e-6f, 0.5f, 0.999f, 1.0f, 1.0001f})
      c.inputs.push_back({{}, {glm::vec3(std::sin(theta), 0.0, std::cos(theta)), cosine}});
  c.exact = [](const glm::dvec4&, const glm::dvec4& b) {
    const double theta = angle_between(glm::dvec3(b), {0.0, 0.0, 1.0}), half = 0.5 * M_PI;
    return glm::dvec4(theta < half ? (kFacets - 1) * std::sqrt(theta / half) : 0.0,
                      (kDifferences - 1) * std::acos(std::clamp(b.w, 0.0, 1.0)) / half, 0.0, 0.0);
  };
  c.variant.flags = {"MULTUM_MEASURED", "MULTUM_FRESNEL"};
  c.variant.formulas = brdf_shader_text("measured.glsl");
  c.variant.set_uniforms = [](const ShaderProgram& program) {
    std::vector<glm::vec3> facets;
    std::vector<float> differences;
    for (int i = 0; i < kFacets; ++i) facets.emplace_back(static_cast<float>(i));
    for (int i = 0; i < kDifferences; ++i) differences.push_back(static_cast<float>(i));
    program.set_vec3("u_facets", glm::value_ptr(facets[0]), kFacets);
    program.set_floats("u_differences", differences.data(), kDifferences);
  };
  compare_glsl(gl, edits, c, worst);
}

std::vector<GlslCase> facet_cases() {
  const std::string longer =
                        "a lobe vector longer than its amplitude makes the highlight narrower than the BRDF allows",
                    unit = "of the peak (the errors of the visibility V and the Fresnel term F are absolute)",
                    reason = "the error of kappa (2.3e-4) changes both the peak and the exponent of the highlight";
  const SourceEdit unclamped = glsl_unclamped_spread();
  const std::string of_all_directions =
      "if normals are spread evenly over all directions, computing |r| / kappa divides 0 by 0";
  const SourceEdit a_third = glsl_edit("r > 1e-3 ? r / kappa : 1.0 / 3.0", "r / kappa");
  return {
      {{"glsl-facets-of-blinn-phong", "blinn_phong.glsl", longer, "the spread is clamped to the range 0 to 1", 6e-4,
        unit, reason},
       {unclamped},
       blinn_phong_facets,
       {"multum_facets", "multum_lobe_facets"}},
      {{"glsl-facets-of-cook-torrance", "torrance_sparrow.glsl, cook_torrance.glsl", longer,
        "the spread is clamped to the range 0 to 1", 6e-4, unit, reason},
       {unclamped},
       cook_torrance_facets,
       {"multum_facets", "multum_lobe_facets", "multum_visibility", "multum_fresnel"}},
      {{"glsl-facets-of-ggx", "ggx.glsl, ggx_lobe.glsl", longer, "the spread is clamped to the range 0 to 1", 3e-3,
        unit, "the texture unit rounds positions in the table to 1/256 of a texel"},
       {unclamped},
       ggx_facets,
       {"multum_facets", "multum_lobe_facets", "multum_visibility", "multum_ggx_lobe_shape",
        "multum_ggx_lobe_density"}},
      {{"glsl-facet-kappa-of-opposite-lobes", "ggx_lobe.glsl",
        "the vectors of the facets and of an opposite lobe of equal sharpness cancel, so normalising their sum divides "
        "by zero",
        "the squared length of the sum is at least 1e-12", 3e-3, "relative error",
        "the sum of two opposite lobes cancels to 1e-7 of its terms"},
       {glsl_edit("sqrt(max(sum * sum - 2.0 * facets * kappa * e, 1e-12))",
                  "sqrt(sum * sum - 2.0 * facets * kappa * e)")},
       facet_kappa_of_opposite_lobes,
       {"multum_ggx_facet_kappa"}},
      {{"glsl-highlights-of-ggx", "ggx_lobe.glsl", longer, "the spread is clamped to the range 0 to 1", 5e-3,
        "of the peak", "the model of the mean cosine has an error of 0.22 %"},
       {unclamped},
       ggx_highlights,
       {"multum_lobe_highlight", "multum_movmf_ggx", "multum_movmf_ggx_facet_kappa", "multum_movmf_ggx_specular",
        "multum_ggx_lobe_specular", "multum_ggx_lobe_facets", "multum_ggx_lobe_curve", "multum_vmf_scatter"}},
      {{"glsl-facets-of-charlie", "charlie.glsl", of_all_directions,
        "below |r| = 0.1, the approximation 1 - 3/5 r^2 is used", 6e-4, unit, reason},
       {glsl_edit("r > 0.1 ? min(3.0 * r / kappa, 1.0) : 1.0 - 0.6 * r * r", "3.0 * r / kappa")},
       charlie_facets,
       {"multum_charlie", "multum_facets", "multum_lobe_facets", "multum_movmf_charlie", "multum_lobe_projection",
        "multum_visibility"}},
      {{"glsl-sheens-at-grazing-angles", "charlie.glsl",
        "if both cosines are 0, then 0.25 is divided by 0, and the resulting infinity is multiplied by 0",
        "the denominator is at least 1e-6", 2e-6, "absolute error", "only one sum of floats is rounded"},
       {glsl_edit("0.25 / max(n_l + n_v - n_l * n_v, 1e-6)", "0.25 / (n_l + n_v - n_l * n_v)")},
       sheen_grazing,
       {"multum_sheen_visibility"}},
      {{"glsl-highlights-of-charlie", "charlie.glsl", of_all_directions, "for |r| up to 1e-3, the limit 1/3 is used",
        2.5e-3, "of the peak", "the model of the mean cosine has an error of 0.22 %"},
       {a_third},
       charlie_highlights,
       {"multum_lobe_highlight", "multum_movmf_charlie_facet_kappa"}},
      {{"glsl-facets-of-terms", "terms.glsl", "terms with negative weights make light far from the peak negative",
        "the sum of the terms is at least 0, and facets that face away reflect nothing", 6e-4, unit, reason},
       {glsl_edit("return lobe.w * max(sum, 0.0);", "return lobe.w * sum;")},
       facets_of_terms,
       {"multum_lobe_facets"}},
      {{"glsl-highlights-of-hard-lobes", "blinn_phong.glsl, torrance_sparrow.glsl, terms.glsl", longer,
        "the spread is clamped to the range 0 to 1", 2.5e-3, "of the peak",
        "the model of the mean cosine has an error of 0.22 %"},
       {unclamped},
       highlights_of_hard_lobes,
       {"multum_lobe_highlight"}},
      {{"glsl-measured-tables-at-their-ends", "measured.glsl",
        "a rounded cosine such as 1.0001 has no arc cosine, so the table index is out of range",
        "the shader clamps v . h to the range 0 to 1 and indices to the table, and facets that face away reflect "
        "nothing",
        3e-2, "absolute error of the index",
        "the GL's inverse trigonometric functions have errors of 5e-4 radians, and one radian spans 57 indices"},
       {glsl_edit("acos(clamp(v_h, 0.0, 1.0))", "acos(v_h)")},
       measured_tables,
       {"multum_facets", "multum_fresnel"}},
  };
}

}  // namespace

std::vector<GlslCase> glsl_brdf_cases() {
  std::vector<GlslCase> cases = {
      {{"glsl-ggx-at-its-peak", "ggx.glsl",
        "near t = 1 (t is a cosine), the difference 1 - t^2 (1 - alpha^2) loses digits by cancellation, which causes "
        "errors of a few per cent at roughness 0.05",
        "the shader computes alpha^2 t^2 + e (2 - e) with e = 1 - t, which is a sum of small terms", 5e-6,
        "relative error", "only two squares are rounded in float"},
       {glsl_edit("x * t * t + e * (2.0 - e)", "1.0 - t * t * (1.0 - x)")},
       ggx_peak,
       {"multum_ggx"}},
      {{"glsl-smith-at-grazing-angles", "ggx.glsl",
        "if both cosines are 0, then 0.5 is divided by 0, and the resulting infinity is multiplied by 0",
        "the denominator is at least 1e-6", 2e-6, "absolute error",
        "only a square root and four products are rounded in float"},
       {glsl_edit("0.5 / max(masking + shadowing, 1e-6)", "0.5 / (masking + shadowing)")},
       smith_grazing,
       {"multum_smith_visibility"}},
      {{"glsl-grooves-at-grazing-angles", "cook_torrance.glsl",
        "a division by a cosine of 0 gives infinity, which is then multiplied by 0",
        "the divisors are the product of the cosines (at least 1e-8) and the larger cosine (at least 1e-4)", 2e-6,
        "absolute error", "only three products are rounded in float"},
       {},
       groove_grazing,
       {"multum_groove_visibility"},
       {glsl_edit("max(n_l * n_v, 1e-8)", "(n_l * n_v)"), glsl_edit("max(max(n_l, n_v), 1e-4)", "max(n_l, n_v)")}},
      {{"glsl-second-zonal-of-broad-lobes", "vmf_zonal.glsl",
        "for broad lobes, 1 - 3 |r| / kappa loses its digits by cancellation, and at |r| = 0 the quotient divides 0 by "
        "0",
        "below |r| = 0.1, the approximation 3/5 r^2 is used", 5e-4, "absolute error",
        "kappa is computed with an error of 2.3e-4"},
       {glsl_edit("r > 0.1 ?", "true ?")},
       second_zonal,
       {"multum_vmf_second_zonal"}},
      {{"glsl-eighth-zonal-of-every-kappa", "vmf_zonal.glsl",
        "a recurrence that starts with a coefficient of 0 fails for large kappa",
        "the recurrence starts twelve orders higher, with the asymptotic quotient of two coefficients", 1e-4,
        "absolute error", "starting twelve orders higher leaves an error of 2.6e-5 at kappa 100"},
       {glsl_edit("float quotient = kappa / (middle + sqrt(middle * middle + kappa * kappa));",
                  "float quotient = 0.0;")},
       eighth_zonal,
       {"multum_vmf_zonal"}},
      {{"glsl-schlick-beyond-its-ends", "cook_torrance.glsl",
        "a cosine above 1 gives a reflectance below F0, and a negative cosine gives too much reflectance",
        "1 - v . h is clamped to the range 0 to 1", 1e-6, "absolute error", "only five products are rounded in float"},
       {glsl_edit("clamp(1.0 - v_h, 0.0, 1.0)", "(1.0 - v_h)")},
       schlick_ends,
       {"multum_schlick"}},
      {{"glsl-terms-of-every-spread", "terms.glsl",
        "the number 1 - |r| A, where A is the mean cosine of the term, loses digits by cancellation",
        "the shader computes d + (1 - d) q with d = 1 - |r| and q = 1 - A, which is a sum of small terms", 6e-4,
        "of the peak", "the error of kappa (2.3e-4) changes both the peak and the exponent of the highlight"},
       {glsl_edit("d + (1.0 - d) * term_spread", "1.0 - (1.0 - d) * (1.0 - term_spread)")},
       terms_of_every_spread,
       {"multum_term"}},
  };
  for (GlslCase& c : facet_cases()) cases.push_back(std::move(c));
  return cases;
}

}  // namespace multum::gl
