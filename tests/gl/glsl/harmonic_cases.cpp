// SPDX-License-Identifier: Apache-2.0
// Defines the numerical cases of sh_shading.glsl.
#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include <glm/mat3x3.hpp>

#include "host/formats/asset/averages/spherical_harmonics.h"
#include "host/lab/reference/shading.h"
#include "host/lab/reference/spherical_harmonics.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/gl/glsl/case_lists.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

constexpr int kUnrolledOrder = 4;  // The order is low because compilers unroll the loops. tests/agreement tests order
                                   // 20.

// Contains sets of directions and a texture of their coefficients. The texture has one row per set.
struct Harmonics {
  int order;
  std::vector<std::vector<glm::dvec3>> sets;
  Texture map;
  ShaderHarnessInput variant;
};

std::vector<std::vector<glm::dvec3>> hard_sets() {
  std::vector<std::vector<glm::dvec3>> sets = {
      {{0.0, 0.0, 1.0}}, {{0.0, 0.0, -1.0}}, {{1.0, 0.0, 0.0}}, {{0.0, 1.0, 0.0}}, {tilted(30.0)}};
  for (const double degrees : {1e-3, 30.0, 89.9, 90.0})
    sets.push_back({tilted(degrees), tilted(degrees, 0.3 + std::numbers::pi)});
  sets.push_back({tilted(10.0, 1.0), tilted(50.0, 2.0), tilted(130.0, 4.0)});
  return sets;
}

std::vector<double> mean_basis(int order, const std::vector<glm::dvec3>& directions) {
  std::vector<double> mean(static_cast<std::size_t>(sh_coefficient_count(order)), 0.0);
  for (const glm::dvec3& n : directions) {
    const std::vector<double> basis = reference::sh_basis_to(order, n);
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += basis[i] / static_cast<double>(directions.size());
  }
  return mean;
}

constexpr char kHarmonicTexts[] =
    "void test_fetch(float set, out vec4 parts[MULTUM_SH_PARTS]) {\n"
    "  for (int i = 0; i < MULTUM_SH_PARTS; ++i) parts[i] = texelFetch(map, ivec2(i, int(set)), 0);\n}\n"
    "float test_lambert(vec3 w, float set) {\n  vec4 parts[MULTUM_SH_PARTS];\n  test_fetch(set, parts);\n"
    "  return multum_sh_lambert(parts, 1.0, w);\n}\n"
    "uniform vec3 u_test_zonal[MULTUM_SH_ORDER + 1];\n"
    "float test_facets(vec3 w, float set) {\n  vec4 parts[MULTUM_SH_PARTS];\n  test_fetch(set, parts);\n"
    "  return multum_sh_facets(parts, 1.0, w, u_test_zonal).x;\n}\n"
    "float test_colour(vec3 w, float set) {\n  vec4 parts[MULTUM_SH_PARTS];\n  test_fetch(set, parts);\n"
    "  vec3 coefficients[MULTUM_SH_COUNT + 1];\n  coefficients[0] = vec3(MULTUM_SH_CONSTANT);\n"
    "  for (int i = 0; i < MULTUM_SH_COUNT; ++i) coefficients[i + 1] = vec3(parts[i >> 2][i & 3]);\n"
    "  return multum_sh_colour(coefficients, w).y;\n}\n"
    "vec4 test_mean(float set) {\n  vec4 parts[MULTUM_SH_PARTS];\n  test_fetch(set, parts);\n"
    "  return vec4(multum_sh_mean_normal(parts), 0.0);\n}\n"
    "vec4 test_moments(float set, int column) {\n  vec4 parts[MULTUM_SH_PARTS];\n  test_fetch(set, parts);\n"
    "  return vec4(multum_sh_second_moments(parts)[column], 0.0);\n}\n";

Harmonics harmonics_of(const GlFunctions& gl, int order, const std::vector<double>& zonal = {}) {
  const std::vector<std::vector<glm::dvec3>> sets = hard_sets();
  const auto parts = static_cast<std::size_t>(sh_part_count(order));
  std::vector<glm::vec4> texels(parts * sets.size(), glm::vec4(0.0f));
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const std::vector<double> mean = mean_basis(order, sets[i]);
    for (std::size_t k = 0; k < mean.size(); ++k)
      texels[i * parts + k / 4][static_cast<int>(k % 4)] = static_cast<float>(mean[k]);
  }
  Harmonics h{order,
              sets,
              Texture(gl, "coefficients", {static_cast<int>(parts), static_cast<int>(sets.size())},
                      {WrapMode::kClamp, WrapMode::kClamp, false, 1.0f}),
              {}};
  h.map.upload_level(0, &texels[0].x);
  h.variant.flags = sh_shading_flags(order);
  h.variant.formulas = std::string(shader_common_sh_shading_glsl) + kHarmonicTexts;
  std::vector<glm::vec3> values(static_cast<std::size_t>(order) + 1, glm::vec3(0.0f));
  for (std::size_t l = 0; l < zonal.size(); ++l) values[l] = glm::vec3(static_cast<float>(zonal[l]));
  h.variant.set_uniforms = [values](const ShaderProgram& program) {
    program.set_vec3("u_test_zonal", &values[0].x, static_cast<int>(values.size()));
  };
  return h;
}

GlslInputs sets_and_directions(std::size_t set_count) {
  GlslInputs inputs;
  for (std::size_t set = 0; set < set_count; ++set) {
    for (const double z : {1.0, -1.0}) inputs.emplace_back(with({0.0, 0.0, z}, static_cast<double>(set)), glm::vec4());
    for (int i = 0; i < 24; ++i)
      inputs.emplace_back(with(tilted(7.5 * (i + 0.5), 1.7 * i), static_cast<double>(set)), glm::vec4());
  }
  return inputs;
}

// Compares both shading functions with the series in double precision, also at the poles. Errors are relative to the
// peak of one tilt.
void harmonics_of_opposite_tilts(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const double s : {12.0, 500.0}) {
    const ZonalCoefficients of_brdf = zonal_blinn_phong(kUnrolledOrder, s), of_lambert = zonal_lambert(kUnrolledOrder);
    Harmonics h = harmonics_of(gl, kUnrolledOrder, of_brdf);
    h.variant.texture = &h.map;
    const double peak = reference::shade_sh(mean_basis(kUnrolledOrder, h.sets[0]), 1.0, of_brdf, h.sets[0][0]);
    GlslComparison c{
        "vec4(test_facets(a.xyz, a.w) / u_facet_total.x, test_lambert(a.xyz, a.w), test_colour(a.xyz, a.w), 0.0)",
        sets_and_directions(h.sets.size()),
        {}};
    c.variant = h.variant;
    c.variant.set_uniforms = [&](const ShaderProgram& program) {
      const glm::vec3 total(static_cast<float>(peak));
      program.set_vec3("u_facet_total", &total.x, 1);
      h.variant.set_uniforms(program);
    };
    c.exact = [&](const glm::dvec4& a, const glm::dvec4&) {
      const std::vector<double> mean = mean_basis(kUnrolledOrder, h.sets[static_cast<std::size_t>(a.w)]);
      const auto shaded = [&](const ZonalCoefficients& zonal) {
        return std::max(reference::shade_sh(mean, 1.0, zonal, glm::dvec3(a)), 0.0);
      };
      const double density = reference::shade_sh(mean, 1.0, ZonalCoefficients(kUnrolledOrder + 1, 1.0), glm::dvec3(a));
      return glm::dvec4(shaded(of_brdf) / peak, shaded(of_lambert), density, 0.0);
    };
    compare_glsl(gl, edits, c, worst);
  }
}

void harmonics_ring_below_0(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const int order : {2, kUnrolledOrder}) {
    Harmonics h = harmonics_of(gl, order, zonal_blinn_phong(order, 1000.0));
    h.variant.texture = &h.map;
    const GlslInputs inputs = sets_and_directions(h.sets.size());
    const char* const text = "vec4(test_facets(a.xyz, a.w), test_lambert(a.xyz, a.w), 0.0, 0.0)";
    const std::vector<glm::vec4> values = evaluate_glsl(gl, edits, text, inputs, h.variant);
    for (std::size_t i = 0; i < values.size(); ++i)
      for (int k = 0; k < 2; ++k) {
        const double value = static_cast<double>(values[i][k]);
        worst.add(std::max(-value, 0.0) + 0.0 * value, fmt::format("order {}, set {}", order, inputs[i].first.w));
      }
  }
}

// Tests E[n] and E[n n^T]. Order 1 has no second moments, so it treats all directions as equally likely.
void moments_of_harmonics(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const int order : {1, 2}) {
    Harmonics h = harmonics_of(gl, order);
    h.variant.texture = &h.map;
    for (int column = -1; column < 3; ++column) {
      GlslComparison c{column < 0 ? "test_mean(a.w)" : fmt::format("test_moments(a.w, {})", column), {}, {}};
      for (std::size_t set = 0; set < h.sets.size(); ++set)
        c.inputs.push_back({with(glm::dvec3(0.0), static_cast<double>(set)), glm::vec4()});
      c.variant = h.variant;
      c.exact = [&](const glm::dvec4& a, const glm::dvec4&) {
        const std::vector<glm::dvec3>& set = h.sets[static_cast<std::size_t>(a.w)];
        glm::dvec3 sum(0.0);
        for (const glm::dvec3& n : set) sum += (column < 0 ? 1.0 : n[std::max(column, 0)]) * n;
        if (column >= 0 && order < 2) return glm::dvec4(glm::dmat3(1.0 / 3.0)[column], 0.0);
        return glm::dvec4(sum / static_cast<double>(set.size()), 0.0);
      };
      compare_glsl(gl, edits, c, worst);
    }
  }
}

}  // namespace

std::vector<GlslCase> glsl_harmonic_cases() {
  const std::string file = "sh_shading.glsl";
  return {
      {{"glsl-harmonics-of-opposite-tilts", file,
        "the sum is wrong at the poles, and for directions and means that are not unit vectors",
        "the series needs no guard, because it handles poles and vectors of any length", 2e-5,
        "of the peak of one tilt",
        "the basis functions have rounding errors in the coefficients and in the evaluation, which the coefficients of "
        "the lobe weight"},
       {glsl_edit("float rotated = c * w.x - s * w.y;", "float rotated = c * w.x;")},
       harmonics_of_opposite_tilts,
       {"multum_sh_coefficient", "multum_sh_bands", "multum_sh_colour", "multum_sh_facets", "multum_sh_lambert"}},
      {{"glsl-harmonics-ring-below-0", file,
        "a truncated series oscillates, and negative light darkens its surroundings", "the result is clamped at 0",
        kNothingWrong, "deviation of light below 0", "no light may be negative"},
       {glsl_edit("return max(sum, vec3(0.0));\n}", "return sum;\n}")},
       harmonics_ring_below_0},
      {{"glsl-moments-of-harmonics", file,
        "the matrix of second moments, E[n n^T], lacks its constant part, which is one third of the identity matrix",
        "the shader adds the constant part, so the trace is 1; for a series of order 1, the matrix is only the "
        "constant part",
        1e-6, "absolute error", "only three sums of a few floats are rounded"},
       {glsl_edit("(parts[1].y / 0.31539157 + 1.0) / 3.0", "(parts[1].y / 0.31539157) / 3.0")},
       moments_of_harmonics,
       {"multum_sh_mean_normal", "multum_sh_second_moments"}},
  };
}

}  // namespace multum::gl
