// SPDX-License-Identifier: Apache-2.0
// Defines the numerical cases of light/. The inputs include directions at the poles of an environment, directions along
// the view, positions at the ends of tables and levels, light from exactly behind, and a light at a point on the
// surface.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "host/foundation/base/split_mix.h"
#include "host/lab/reference/shading.h"
#include "host/lab/reference/spherical_harmonics.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/gl/glsl/case_lists.h"
#include "tests/gl/glsl/environment_inputs.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

void places_at_the_poles(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const glm::vec3 axes[] = {glm::vec3(tilted(90.0, 0.5)), glm::vec3(tilted(0.0)),
                            glm::vec3(tilted(90.0, 0.5 - M_PI / 2))};
  GlslComparison c{"vec4(multum_environment_st(a.xyz), test_framed(a.xyz).xy)", {}, {}};
  for (const double y : {1.0001, 1.0, 0.9999, 0.3, 0.0, -0.5, -1.0, -1.0001})
    for (const double azimuth : {-3.0, -1.0, 0.0, 0.5, 2.0, 3.0}) {
      const double side = std::sqrt(std::max(1.0 - y * y, 0.0));
      c.inputs.push_back({with({side * std::sin(azimuth), y, -side * std::cos(azimuth)}, 0.0), {}});
    }
  c.variant.formulas = std::string(shader_light_environment_frame_glsl) +
                       "vec3 test_framed(vec3 d) {\n"
                       "  multum_set_environment_frame(mat3(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0));\n"
                       "  return multum_environment_frame * d;\n}\n";
  c.variant.set_uniforms = [&](const ShaderProgram& program) {
    program.set_vec3("u_environment_axes", glm::value_ptr(axes[0]), 3);
  };
  c.exact = [&](const glm::dvec4& a, const glm::dvec4&) {
    const glm::dvec3 turned(-a.y, a.x, a.z);
    const double ahead = a.x == 0.0 && a.z == 0.0 ? 1.0 : -a.z;
    return glm::dvec4(0.5 + std::atan2(a.x, ahead) / (2.0 * M_PI), std::acos(std::clamp(a.y, -1.0, 1.0)) / M_PI,
                      glm::dot(glm::dvec3(axes[0]), turned), glm::dot(glm::dvec3(axes[1]), turned));
  };
  compare_glsl(gl, edits, c, worst);
}

// Tests normals all around a strong light. For normals that face away from the light, the series of two bands is
// negative.
void irradiance_behind_the_light(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const double mean : {1.0, 0.1}) {
    const SmoothLight light = {mean, {0.3, -0.4, 1.0}};
    GlslComparison c{"vec4(test_irradiance(a.xyz, 1.0, 1.0), test_irradiance(a.xyz, 0.0, 0.0).x)", {}, {}};
    for (int i = 0; i <= 12; ++i) c.inputs.push_back({with(tilted(15.0 * i, 1.0 * i), 0.0), {}});
    c.variant = environment_variant("");
    c.variant.formulas +=
        "vec3 test_irradiance(vec3 mu, float a1, float a2) {\n  multum_environment_frame = mat3(1.0);\n"
        "  return multum_irradiance(mu, a1, a2);\n}\n";
    c.variant.set_uniforms = [&](const ShaderProgram& program) { set_smooth_light(program, light); };
    c.exact = [&](const glm::dvec4& a, const glm::dvec4&) {
      return glm::dvec4(glm::dvec3(std::max(light.irradiance(glm::dvec3(a)), 0.0)), M_PI * mean);
    };
    compare_glsl(gl, edits, c, worst);
  }
}

// Each entry contains its own position. Hence a value that the shader reads shows which position it used, and whether
// it mixed in another plane.
void table_at_its_ends(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr int kColumns = 32, kRows = 24, kPlanes = 3;
  std::vector<glm::vec4> texels;
  for (int plane = 0; plane < kPlanes; ++plane)
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < kColumns; ++column)
        texels.emplace_back(1000.0f * static_cast<float>(plane), column, row, 1.0f);
  Texture table(gl, "table", {kColumns, kRows * kPlanes}, {WrapMode::kClamp, WrapMode::kClamp, true, 1.0f});
  table.upload_level(0, &texels[0].x);
  GlslComparison c{"multum_reflection_entry(int(b.x), a.x, a.y)", {}, {}};
  for (int plane = 0; plane < kPlanes; ++plane)
    for (const float cosine : {-1.000001f, -1.0f, -0.99f, 0.0f, 0.7f, 1.0f, 1.000001f})
      for (const float spread : {0.0f, 1e-12f, 1e-6f, 0.1f, 0.999f, 1.0f})
        c.inputs.push_back({{cosine, spread, 0.0f, 0.0f}, glm::vec4(static_cast<float>(plane))});
  c.variant = environment_variant("");
  c.variant.set_uniforms = [&](const ShaderProgram& program) {
    program.set("u_reflection_table", 3);
    table.bind(3);
  };
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    return glm::dvec4(1000.0 * b.x, (0.5 + 0.5 * std::clamp(a.x, -1.0, 1.0)) * (kColumns - 1),
                      std::cbrt(a.y) * (kRows - 1), 1.0);
  };
  compare_glsl(gl, edits, c, worst);
}

void levels_beyond_their_ends(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_environment_level(a.x), 0.0, 0.0, 0.0)", {}, {}};
  for (const float spread : {0.0f, 1e-6f, 1e-3f, 5e-3f, 1e-2f, 0.05f, 0.1f, 0.3f, 0.5f, 0.9f, 1.0f})
    c.inputs.push_back({glm::vec4(spread), {}});
  c.variant = environment_variant("");
  c.variant.set_uniforms = set_levels;
  c.exact = [](const glm::dvec4& a, const glm::dvec4&) {
    int k = 0;
    while (k < kLevelCount - 2 && a.x > static_cast<double>(kLevelSpreads[k + 1])) ++k;
    const double low = static_cast<double>(kLevelSpreads[k]), high = static_cast<double>(kLevelSpreads[k + 1]);
    return glm::dvec4(k + std::clamp((a.x - low) / (high - low), 0.0, 1.0), 0.0, 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Tests equal light from every direction: a lobe of any width reflects exactly this light. The inputs include views
// along the lobe, for which v and mu do not span a plane.
void seen_along_the_lobe(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const ConstantLight light(gl);
  GlslComparison c{"", {}, {}};
  for (const glm::vec4& lobe :
       {glm::vec4(0.0f, 0.0f, 1.0f, 1.0f), glm::vec4(0.0f, 0.0f, 1.0001f, 1.0f), glm::vec4(0.0f, 0.0f, 0.45f, 0.5f),
        glm::vec4(0.0f, 0.0f, 0.0f, 1.0f), glm::vec4(0.0f, 0.0f, 1e-9f, 1e-8f), glm::vec4(0.0f)})
    for (const double degrees : {0.0, 1e-4, 0.01, 30.0, 60.0}) c.inputs.push_back({lobe, with(tilted(degrees), 0.0)});
  c.variant = environment_variant(
      "MultumReflection test_lobe(vec4 lobe, vec3 v) {\n  multum_environment_frame = mat3(1.0);\n"
      "  return multum_environment_lobe(lobe, v);\n}\n");
  c.variant.set_uniforms = [&](const ShaderProgram& program) { light.set(program); };
  for (const bool diffuse : {true, false}) {
    c.expression = fmt::format("vec4(test_lobe(a, b.xyz).{}, 0.0)", diffuse ? "diffuse" : "specular");
    c.exact = [&](const glm::dvec4& a, const glm::dvec4&) {
      const double amplitude = a.w <= 1e-6 ? 0.0 : a.w;
      return glm::dvec4(amplitude * (diffuse ? ConstantLight::irradiance() : ConstantLight::highlight()), 0.0);
    };
    compare_glsl(gl, edits, c, worst);
  }
}

// Tests each harmonic of the half vector's light separately, with lobes of every width, also at the poles. Then tests
// the case without light.
void harmonics_of_half_vectors(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr int kOrder = 8, kCount = (kOrder + 1) * (kOrder + 1), kGrid = 2;
  SplitMix64 random(81);
  std::vector<glm::vec4> coefficients, texels;
  for (int i = 0; i < kCount; ++i) {
    coefficients.emplace_back(random.uniform(), random.uniform() - 0.5, i == 0 ? 1.0 : 0.0, 0.0);
    for (int k = 0; k < kGrid * kGrid; ++k) texels.push_back(coefficients.back());
  }
  Texture planes(gl, "half vectors", {kGrid, kGrid * kCount}, {WrapMode::kClamp, WrapMode::kClamp, true, 1.0f});
  planes.upload_level(0, &texels[0].x);
  std::vector<glm::vec3> zonal;
  for (int l = 0; l <= kOrder; ++l) zonal.emplace_back(1.0f / static_cast<float>(l + 1));
  for (const float of_table : {0.5f, 0.0f}) {
    const Texture table = flat_texture(gl, glm::vec4(of_table));
    GlslComparison c{"vec4(test_specular(a.xyz, b.x), 0.0)", {}, {}};
    for (const double degrees : {0.0, 1e-4, 40.0, 90.0, 150.0, 180.0})
      for (const float d : {1e-6f, 0.01f, 0.3f, 0.9f, 0.9999f})
        c.inputs.push_back({with(tilted(degrees, 2.0), 0.0), glm::vec4(d)});
    c.variant.flags = {"MULTUM_ENVIRONMENT_TERMS 1"};
    c.variant.formulas = std::string(shader_light_environment_frame_glsl) + shader_light_environment_glsl +
                         shader_light_environment_sh_glsl +
                         "vec3 test_specular(vec3 mu, float d) {\n  multum_environment_frame = mat3(1.0);\n"
                         "  return multum_environment_specular(mu, d, mu);\n}\n";
    c.variant.set_uniforms = [&](const ShaderProgram& program) {
      const float grid[] = {kGrid, kGrid}, viewport[] = {1000.0f, 1000.0f};
      program.set_vec2("u_half_grid", grid);
      program.set_vec2("u_viewport", viewport);
      program.set_vec3("u_half_zonal", glm::value_ptr(zonal[0]), kOrder + 1);
      program.set("u_half_vector_light", 3);
      program.set("u_reflection_table", 4);
      planes.bind(3);
      table.bind(4);
    };
    c.exact = [&](const glm::dvec4& a, const glm::dvec4& b) {
      if (of_table == 0.0f) return glm::dvec4(0.0);
      const double kappa = reference::vmf_kappa(b.x);
      glm::dvec3 sum = glm::dvec3(coefficients[0]) * (0.5 / std::sqrt(M_PI));
      for (int l = 1; l <= kOrder; ++l)
        for (int m = -l; m <= l; ++m)
          sum += glm::dvec3(coefficients[static_cast<std::size_t>(l * (l + 1) + m)]) *
                 (reference::zonal_of_vmf(kappa, l) / (l + 1) * reference::sh_basis(l, m, glm::dvec3(a)));
      return glm::dvec4(glm::max(sum, glm::dvec3(0.0)), 0.0);
    };
    compare_glsl(gl, edits, c, worst);
  }
}

std::uint32_t lowbias(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

ShaderHarnessInput sampling_variant(const Texture& map, float exponent) {
  ShaderHarnessInput variant;
  variant.flags = {"MULTUM_REFERENCE", "MULTUM_BLINN_PHONG", "MULTUM_ENVIRONMENT_SAMPLES 4"};
  variant.formulas = std::string(shader_light_environment_frame_glsl) + shader_light_environment_samples_glsl +
                     "vec4 test_add(vec3 n, vec3 l, vec3 v, float alpha) {\n  multum_environment_frame = mat3(1.0);\n"
                     "  MultumReflection sum = MultumReflection(vec3(0.0), vec3(0.0));\n"
                     "  multum_add_direction(0, l, n, v, alpha, sum);\n"
                     "  return vec4(sum.diffuse.x, sum.specular.x, 0.0, 0.0);\n}\n";
  variant.set_uniforms = [&map, exponent](const ShaderProgram& program) {
    program.set("u_exponent", exponent);
    program.set("u_light_total", 4.0f);
    program.set("u_environment_map", 3);
    map.bind(3);
  };
  return variant;
}

constexpr float kTexelRadiance = 0.25f;  // every texel has this radiance
constexpr double kLightDensity = 0.25 / 4.0;

// Tests densities relative to the peak of GGX, with v.h down to 0.
void densities_at_their_ends(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const Texture map = flat_texture(gl, glm::vec4(kTexelRadiance));
  GlslComparison c{
      "vec4(multum_half_density(a.x, a.y, a.z) * 4.0 * max(a.z, 1e-6) * MULTUM_PI * a.x, "
      "multum_cosine_density(a.y), multum_light_density(vec3(a.w)), "
      "float(multum_light_hash(uint(b.x)) >> 8u) / 16777216.0)",
      {},
      {}};
  for (const float alpha : {2e-5f, 1e-3f, 0.1f, 1.0f})
    for (const float n_h : {-1.0f, 0.0f, 1e-3f, 0.5f, 0.999f, 1.0f})
      for (const float v_h : {0.0f, 1e-30f, 1e-7f, 0.5f, 1.0f})
        c.inputs.push_back({{alpha, n_h, v_h, kTexelRadiance}, glm::vec4(static_cast<float>(c.inputs.size() * 7919))});
  c.variant = sampling_variant(map, 100.0f);
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double y = 1.0 + (a.x - 1.0) * a.y * a.y;
    return glm::dvec4(a.y <= 0.0 ? 0.0 : a.x * a.x * a.y / (y * y), a.y / M_PI, kLightDensity,
                      static_cast<double>(lowbias(static_cast<std::uint32_t>(b.x)) >> 8u) / 16777216.0);
  };
  compare_glsl(gl, edits, c, worst);
}

void directions_at_the_pole(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const Texture map = flat_texture(gl, glm::vec4(kTexelRadiance));
  GlslComparison c{"vec4(multum_direction(mat3(1.0), a.x, a.y), 0.0)", {}, {}};
  for (const float cosine : {1.0001f, 1.0f, 0.9999f, 0.5f, 0.0f, -1.0f, -1.0001f})
    for (const float phi : {0.0f, 1.0f, 3.0f, 6.28f}) c.inputs.push_back({{cosine, phi, 0.0f, 0.0f}, {}});
  c.variant = sampling_variant(map, 100.0f);
  c.exact = [](const glm::dvec4& a, const glm::dvec4&) {
    const double sine = std::sqrt(std::max(1.0 - a.x * a.x, 0.0));
    return glm::dvec4(sine * std::cos(a.y), sine * std::sin(a.y), a.x, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Tests light opposite to the view, which has no half vector, and normals that face away from the viewer.
void a_sample_straight_behind(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr double kAlpha = 0.02, kExponent = 10.0;
  const Texture map = flat_texture(gl, glm::vec4(kTexelRadiance));
  GlslComparison c{fmt::format("test_add(a.xyz, b.xyz, vec3(0.0, 0.0, 1.0), {})", kAlpha), {}, {}};
  for (const double tilt : {0.0, 60.0, 89.0, 120.0, 180.0})
    for (const double degrees : {0.0, 45.0, 90.0, 150.0, 180.0}) {
      const glm::dvec3 l = degrees == 180.0 ? glm::dvec3(0.0, 0.0, -1.0) : tilted(degrees, 1.0);
      c.inputs.push_back({with(tilted(tilt), 0.0), with(l, 0.0)});
    }
  c.variant = sampling_variant(map, static_cast<float>(kExponent));
  c.exact = [&](const glm::dvec4& a, const glm::dvec4& b) {
    const glm::dvec3 n(a), l(b), h = half_vector(l, {0.0, 0.0, 1.0});
    const double n_l = glm::dot(n, l), radiance = static_cast<double>(kTexelRadiance), n_h = glm::dot(n, h);
    if (n_l <= 0.0) return glm::dvec4(0.0);
    const double y = 1.0 + (kAlpha - 1.0) * n_h * n_h;
    const double found = n_h <= 0.0 ? 0.0 : kAlpha * n_h / (M_PI * y * y) / (4.0 * std::max(h.z, 1e-6));
    return glm::dvec4(radiance * n_l / (kLightDensity + n_l / M_PI),
                      reference::blinn_phong(kExponent, angle_between(n, h)) * radiance * n_l / (kLightDensity + found),
                      0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

constexpr float kDiffuse = 0.75f, kSpecular = 0.5f, kLitExponent = 20.0f;

ShaderHarnessInput lights_variant(const glm::vec3& point) {
  ShaderHarnessInput variant;
  variant.flags = {"MULTUM_LOBE_COUNT 1", "MULTUM_BLINN_PHONG", "MULTUM_DIRECTIONAL_LIGHTS 1", "MULTUM_POINT_LIGHTS 1"};
  variant.formulas = std::string(shader_surface_lobes_glsl) + shader_surface_movmf_glsl + shader_light_lights_glsl +
                     "MultumSurface test_surface(vec4 lobe) {\n  MultumSurface surface;\n  surface.lobes[0] = lobe;\n"
                     "  return surface;\n}\n";
  variant.set_uniforms = [point](const ShaderProgram& program) {
    const glm::vec3 k_d(kDiffuse), k_s(kSpecular), up(0.0f, 0.0f, 1.0f), one(1.0f);
    program.set("u_exponent", kLitExponent);
    program.set_vec3("u_diffuse", &k_d.x, 1);
    program.set_vec3("u_specular", &k_s.x, 1);
    program.set_vec3("u_light_directions", &up.x, 1);
    program.set_vec3("u_light_irradiances", &one.x, 1);
    program.set_vec3("u_point_positions", &point.x, 1);
    program.set_vec3("u_point_intensities", &one.x, 1);
  };
  return variant;
}

// Returns the ratio of radiance to irradiance for a lobe of one direction.
double radiance_of(const glm::dvec3& n, const glm::dvec3& l, const glm::dvec3& v) {
  const double n_l = std::max(glm::dot(n, l), 0.0), s = static_cast<double>(kLitExponent);
  return n_l * (static_cast<double>(kDiffuse) / M_PI +
                static_cast<double>(kSpecular) * reference::blinn_phong(s, angle_between(n, half_vector(l, v))));
}

void light_straight_behind(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_radiance(test_surface(a), b.xyz, vec3(0.0, 0.0, 1.0)), 0.0)", {}, {}};
  for (const double tilt : {0.0, 60.0, 89.0, 120.0, 180.0})
    for (const double degrees : {0.0, 45.0, 90.0, 150.0, 180.0}) {
      const glm::dvec3 l = degrees == 180.0 ? glm::dvec3(0.0, 0.0, -1.0) : tilted(degrees, 1.0);
      c.inputs.push_back({with(tilted(tilt), 1.0), with(l, 0.0)});
    }
  c.variant = lights_variant(glm::vec3(0.0f, 0.0f, 1.0f));
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    return glm::dvec4(glm::dvec3(radiance_of(glm::dvec3(a), glm::dvec3(b), {0.0, 0.0, 1.0})), 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Tests a light at the lit point itself. Such a light has no direction. Elsewhere, its irradiance decreases with the
// squared distance.
void a_light_on_the_surface(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const glm::vec3& point : {glm::vec3(0.0f), glm::vec3(0.0f, 3.0f, 4.0f), glm::vec3(0.0f, 0.0f, -1e-3f)}) {
    GlslComparison c{"vec4(multum_lights(test_surface(a), mat3(1.0), vec3(0.0), b.xyz), 0.0)", {}, {}};
    for (const double tilt : {0.0, 30.0, 80.0}) c.inputs.push_back({with(tilted(tilt), 1.0), with(tilted(20.0), 0.0)});
    c.variant = lights_variant(point);
    c.exact = [&](const glm::dvec4& a, const glm::dvec4& b) {
      const glm::dvec3 n(a), v(b), to(point);
      const double square = std::max(glm::dot(to, to), 1e-12);
      return glm::dvec4(
          glm::dvec3(radiance_of(n, {0.0, 0.0, 1.0}, v) + radiance_of(n, to / std::sqrt(square), v) / square), 0.0);
    };
    compare_glsl(gl, edits, c, worst);
  }
}

std::vector<GlslCase> sample_cases() {
  const std::string file = "environment_samples.glsl";
  return {
      {{"glsl-densities-at-their-ends", file,
        "if the view v is perpendicular to the half vector h, a density is divided by v . h = 0",
        "v . h counts as at least 1e-6", 2e-2, "error (relative to the peak, or absolute)",
        "1 - (n . h)^2 is rounded in float, and a highlight with exponent 1e5 is so narrow that the rounding is "
        "visible"},
       {glsl_edit("(4.0 * max(v_h, 1e-6))", "(4.0 * v_h)")},
       densities_at_their_ends,
       {"multum_half_density", "multum_cosine_density", "multum_light_density", "multum_light_hash"}},
      {{"glsl-directions-at-the-pole", file,
        "rounding makes the cosine larger than 1, so the sine is the square root of a negative number",
        "the squared sine is at least 0", 1e-5, "absolute error", "the GL's sine and cosine functions are not exact"},
       {glsl_edit("sqrt(max(1.0 - cosine * cosine, 0.0))", "sqrt(1.0 - cosine * cosine)")},
       directions_at_the_pole,
       {"multum_direction"}},
      {{"glsl-a-sample-straight-behind", file,
        "if the light is opposite to the view (l = -v), their sum is 0, and normalising the half vector divides by "
        "zero",
        "the divisor is at least 1e-6, so the half vector is 0 and highlights stay finite", 1e-5, "absolute error",
        "the normal n and the half vector h have rounding errors of up to 6e-8, and the exponent 10 multiplies the "
        "error"},
       {glsl_edit("sum / max(length(sum), 1e-6)", "normalize(sum)")},
       a_sample_straight_behind,
       {"multum_add_direction", "multum_environment_radiance", "multum_diffuse_integrand",
        "multum_specular_integrand"}},
  };
}

std::vector<GlslCase> light_cases() {
  return {
      {{"glsl-light-straight-behind", "lights.glsl, reflection.glsl",
        "if the light is opposite to the view (l = -v), their sum is 0, and normalising the half vector divides by "
        "zero",
        "the divisor is at least 1e-6, so the half vector is 0 and highlights stay finite", 1e-5, "absolute error",
        "the normal n and the half vector h have rounding errors of up to 6e-8, and the exponent 20 multiplies the "
        "error"},
       {glsl_edit("sum / max(length(sum), 1e-6)", "normalize(sum)")},
       light_straight_behind,
       {"multum_half_vector", "multum_outgoing", "multum_radiance"}},
      {{"glsl-a-light-on-the-surface", "lights.glsl",
        "a light at distance 0 has infinite intensity, which is multiplied by a cosine of 0",
        "the squared distance is at least 1e-12", 1e-5, "absolute error",
        "the normal n and the half vector h have rounding errors of up to 6e-8, and the exponent 20 multiplies the "
        "error"},
       {glsl_edit("max(dot(to_light, to_light), 1e-12)", "dot(to_light, to_light)")},
       a_light_on_the_surface,
       {"multum_lights"}},
  };
}

}  // namespace

std::vector<GlslCase> glsl_light_cases() {
  std::vector<GlslCase> cases = {
      {{"glsl-environment-at-its-poles", "environment_frame.glsl",
        "a rounded height such as 1.0001 has no arc cosine, and the azimuth of the direction straight up is atan(0, 0)",
        "heights are clamped to the range -1 to 1, and the directions straight up and straight down map to s = 0.5",
        1e-3, "absolute error of s and t", "the GL's inverse trigonometric functions are not exact"},
       {glsl_edit("acos(clamp(d.y, -1.0, 1.0))", "acos(d.y)")},
       places_at_the_poles,
       {"multum_environment_st", "multum_set_environment_frame"}},
      {{"glsl-irradiance-behind-the-light", "environment.glsl",
        "a series of only two bands becomes negative on the side opposite to a strong light", "the sum is at least 0",
        1e-4, "absolute error",
        "the expected value is a numerical integral over 200 rings, which has an error of its own"},
       {glsl_edit(
           "return max(MULTUM_PI * (u_smooth_mean + 2.0 / 3.0 * a1 * linear + 0.25 * a2 * quadratic), vec3(0.0));",
           "return MULTUM_PI * (u_smooth_mean + 2.0 / 3.0 * a1 * linear + 0.25 * a2 * quadratic);")},
       irradiance_behind_the_light,
       {"multum_irradiance"}},
      {{"glsl-reflection-table-at-its-ends", "environment.glsl",
        "the filter mixes values of the next plane into the last texels of a plane",
        "the shader clamps coordinates to the range between the centres of the first and the last texel", 1e-1,
        "absolute error of the index", "texture filter weights have only 8 bits, and the table has 24 rows"},
       {glsl_edit("0.5 + pow(spread, 1.0 / 3.0)", "pow(spread, 1.0 / 3.0)")},
       table_at_its_ends,
       {"multum_reflection_entry"}},
      {{"glsl-environment-levels-at-their-ends", "environment_levels.glsl",
        "a spread outside the range of the levels selects a level that does not exist",
        "the share is clamped to the range 0 to 1", 1e-5, "absolute error of the level",
        "a difference and a quotient are rounded"},
       {glsl_edit("clamp((spread - low) / (u_level_spreads[k + 1] - low), 0.0, 1.0)",
                  "((spread - low) / (u_level_spreads[k + 1] - low))")},
       levels_beyond_their_ends,
       {"multum_environment_level"}},
      {{"glsl-environment-seen-along-the-lobe", "environment.glsl, environment_levels.glsl",
        "if the view direction v is parallel to the lobe's direction mu, they span no plane, and normalisation divides "
        "by zero",
        "if v and mu are parallel, the shader uses an arbitrary plane that contains mu", 1e-4, "absolute error",
        "the result is the sum of nine equal texels, whose weights are rounded"},
       {glsl_edit("if (dot(side, side) < 1e-6) side =", "if (false) side =")},
       seen_along_the_lobe,
       {"multum_environment_lobe", "multum_environment_specular", "multum_term_light"}},
      {{"glsl-environment-harmonics-of-no-light", "environment_sh.glsl",
        "an environment without light has a weight of 0, and the shader divides by the weight",
        "the divisor is at least 1e-6", 5e-4, "absolute error",
        "the error of kappa (2.3e-4) affects each of eight bands"},
       {glsl_edit("weight / max(plain, 1e-6)", "weight / plain")},
       harmonics_of_half_vectors,
       {"multum_half_vector_light", "multum_reflection_quotient", "multum_environment_specular"}},
  };
  for (auto* part : {sample_cases, light_cases})
    for (GlslCase& c : part()) cases.push_back(std::move(c));
  return cases;
}

}  // namespace multum::gl
