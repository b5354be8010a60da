// SPDX-License-Identifier: Apache-2.0
// Defines the numerical cases of surface/ and of the tangent frame of a mesh. Compares every representation of a single
// normal with the normal in double precision. The views are from above, from below and from exactly behind. Also tests
// an empty material.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "host/formats/asset/averages/spherical_harmonics.h"
#include "host/lab/reference/planar_em.h"
#include "host/lab/reference/shading.h"
#include "host/lab/reference/spherical_harmonics.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/gl/glsl/case_lists.h"
#include "tests/gl/glsl/environment_inputs.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

constexpr double kFacetExponent = 16.0;
const double kSigma = 0.25, kFacetKappa = 0.5 / (kSigma * kSigma);
const glm::dvec3 kView(0.0, 0.0, 1.0);

// Computes V of cook_torrance.glsl without dividing by a cosine that can be 0.
double visibility(double n_l, double n_v, double n_h, double v_h) {
  const double groove = 2.0 * n_h / std::max(v_h, 1e-4);
  return 0.25 * std::min(1.0 / std::max(n_l * n_v, 1e-8), groove / std::max({n_l, n_v, 1e-4}));
}

const std::vector<std::string> kBlinnPhongFlags = {"MULTUM_BLINN_PHONG"};
const std::vector<std::string> kCookTorrance = {"MULTUM_TORRANCE_SPARROW", "MULTUM_COOK_TORRANCE", "MULTUM_VISIBILITY"};

double facets_of_vmf(const glm::dvec3& n, const glm::dvec3& h) {
  return reference::vmf_density(kFacetKappa, angle_between(n, h));
}

double blinn_phong(const glm::dvec3& n, const glm::dvec3& h) {
  return reference::blinn_phong(kFacetExponent, angle_between(n, h));
}

// Describes one representation of the normal a.xyz with amplitude a.w: its input to the shader, and its f(n . h).
struct SurfaceTest {
  std::vector<std::string> flags;
  std::string texts;
  std::string fill;  // statements that fill `surface` from `a`
  bool has_visibility;
  double normal_degrees_max = 180.0;
  std::function<double(const glm::dvec3& n, const glm::dvec3& l)> diffuse =
      [](const glm::dvec3& n, const glm::dvec3& l) { return std::max(glm::dot(n, l), 0.0); };
  std::function<double(const glm::dvec3& n, const glm::dvec3& h)> facets = blinn_phong;
};

GlslComparison comparison_of(const SurfaceTest& test) {
  GlslComparison c{"test_reflect(a, b.xyz)", {}, {}};
  c.variant.flags = test.flags;
  c.variant.formulas = test.texts + "vec4 test_reflect(vec4 a, vec3 l) {\n  MultumSurface surface;\n" + test.fill +
                       "  vec3 v = vec3(0.0, 0.0, 1.0);\n"
                       "  MultumReflection r = multum_reflect(surface, l, v, multum_half_vector(l, v));\n"
                       "  return vec4(r.diffuse.x, r.specular.x, 0.0, 0.0);\n}\n";
  return c;
}

void set_brdf_uniforms(const ShaderProgram& program) {
  const glm::vec3 one(1.0f);
  program.set("u_exponent", static_cast<float>(kFacetExponent));
  program.set("u_sigma", static_cast<float>(kSigma));
  program.set("u_mean_cosine", 1.0f);
  program.set_vec3("u_facet_total", &one.x, 1);
}

void compare_surface(const GlFunctions& gl, const Edits& edits, const SurfaceTest& test, WorstError& worst) {
  GlslComparison c = comparison_of(test);
  for (const double tilt : {0.0, 30.0, 60.0, 89.0, 120.0, 180.0})
    for (const double degrees : {0.0, 45.0, 89.0, 91.0, 150.0, 180.0}) {
      if (tilt > test.normal_degrees_max) continue;
      const glm::dvec3 l = degrees == 180.0 ? -kView : tilted(degrees, 1.0);
      c.inputs.push_back({with(tilted(tilt), 1.0), with(l, 0.0)});
      c.inputs.push_back({glm::vec4(0.0f), with(l, 0.0)});  // no material
    }
  c.variant.set_uniforms = set_brdf_uniforms;
  c.exact = [&](const glm::dvec4& a, const glm::dvec4& b) {
    if (a.w == 0.0) return glm::dvec4(0.0);
    const glm::dvec3 n(a), l(b), h = half_vector(l, kView);
    const double n_l = std::max(glm::dot(n, l), 0.0), n_v = std::max(n.z, 0.0);
    double highlight = test.facets(n, h) * n_l;
    if (test.has_visibility) highlight *= visibility(n_l, n_v, std::max(glm::dot(n, h), 0.0), std::max(h.z, 0.0));
    return glm::dvec4(test.diffuse(n, l), highlight, 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

std::string lobe_texts() { return std::string(shader_surface_lobes_glsl) + shader_surface_movmf_glsl; }

void single_normals_as_lobes(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  SurfaceTest test{kCookTorrance, lobe_texts(), "  surface.lobes[0] = a;\n", true};
  test.flags.push_back("MULTUM_LOBE_COUNT 1");
  test.facets = facets_of_vmf;
  compare_surface(gl, edits, test, worst);
}

// Tests `d h + mu / s` with a half vector opposite to mu, so that the two terms cancel. Also tests other sums that have
// no direction.
void visibility_of_opposite_half_vectors(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  SurfaceTest test{kCookTorrance, lobe_texts(), "", true};
  GlslComparison c{"vec4(test_highlight(a, vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), b.xyz), 0.0, 0.0, 0.0)", {}, {}};
  test.flags.push_back("MULTUM_LOBE_COUNT 1");
  for (const glm::vec4& lobe :
       {glm::vec4(0.0f, 0.0f, 0.9375f, 1.0f), glm::vec4(0.0f, 0.0f, 0.0f, 1.0f), glm::vec4(0.0f)})
    for (const glm::vec3& h : {glm::vec3(0.0f, 0.0f, -1.0f), glm::vec3(0.0f), glm::vec3(0.0f, 0.0f, 1.0f),
                               glm::vec3(tilted(60.0)), glm::vec3(tilted(100.0))})
      c.inputs.push_back({lobe, {h, 0.0f}});
  c.variant.flags = test.flags;
  c.variant.formulas = test.texts +
                       "float test_highlight(vec4 a, vec3 l, vec3 v, vec3 h) {\n"
                       "  return multum_lobe_highlight(a, h, l).x * multum_lobe_visibility(a, l, v, h);\n}\n";
  c.variant.set_uniforms = set_brdf_uniforms;
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double spread = std::clamp((a.w - a.z) / std::max(a.w, 1e-6), 0.0, 1.0);
    const glm::dvec3 h(b), n = spread * h + glm::dvec3(0.0, 0.0, 1.0 / kFacetExponent);
    const double length = glm::length(n), n_h = length < 1e-9 ? 0.0 : std::max(glm::dot(n, h), 0.0) / length;
    const glm::dvec3 sum =
        kFacetKappa * glm::dvec3(b) + glm::dvec3(0.0, 0.0, spread == 1.0 ? 0.0 : reference::vmf_kappa(spread));
    const double n_l = a.w == 0.0 ? 0.0 : highlight_cosine(sum, {0.0, 1.0, 0.0}),
                 n_v = a.w == 0.0 ? 0.0 : highlight_cosine(sum, {1.0, 0.0, 0.0});
    const double q = spread + (1.0 - spread) * reference::vmf_spread(kFacetKappa);
    const double e = 0.5 * glm::dot(h - glm::dvec3(0.0, 0.0, 1.0), h - glm::dvec3(0.0, 0.0, 1.0));
    const double kappa = reference::vmf_kappa(q), facets = reference::vmf_density(kappa, 0.0) * std::exp(-kappa * e);
    const double v_h = h.x;
    return glm::dvec4(a.w * facets * n_l * visibility(n_l, n_v, n_h, v_h), 0.0, 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

void single_normals_as_gaussians(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  SurfaceTest test{kCookTorrance, std::string(shader_surface_lobes_glsl) + shader_surface_gmm_glsl,
                   "  surface.lobes[0] = a.w * vec4(a.xy, dot(a.xy, a.xy), 1.0);\n", true, 89.0};
  test.flags.push_back("MULTUM_LOBE_COUNT 1");
  test.facets = [](const glm::dvec3& n, const glm::dvec3& h) {
    return reference::gmm_density(glm::dvec4(n.x, n.y, n.x * n.x + n.y * n.y, 1.0), kFacetExponent, h);
  };
  compare_surface(gl, edits, test, worst);
}

// Tests the shading of one normal (MIP), and Toksvig's rule, which also stores the roughness in the length of the
// normal.
void single_normals_as_means(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const char* mode : {"MULTUM_MIP", "MULTUM_TOKSVIG"}) {
    SurfaceTest test{kBlinnPhongFlags, shader_surface_normals_glsl,
                     "  surface.normal = a;\n  surface.albedo = vec3(1.0);\n  surface.weight = 1.0;\n", false};
    test.flags.push_back(mode);
    compare_surface(gl, edits, test, worst);
  }
}

// Tests the conversion of a roughness map's exponents to variances, from mirrors to the roughest texel.
void exponents_of_roughness(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr double kMirrorExponent = 1e5;
  GlslComparison c{"test_variances(a.x)", {}, {}};
  c.variant.flags = kBlinnPhongFlags;
  c.variant.flags.insert(c.variant.flags.end(), {"MULTUM_MIP", "MULTUM_ROUGHNESS_MAP"});
  c.variant.formulas =
      std::string(shader_surface_normals_glsl) +
      "vec4 test_variances(float roughness) {\n  MultumSurface surface;\n"
      "  surface.roughness = roughness;\n"
      "  return vec4(1.0 / (multum_exponent(surface) + 2.0), 1.0 / multum_slope_exponent(surface), 0.0,\n"
      "              0.0);\n}\n";
  c.variant.set_uniforms = [](const ShaderProgram& program) {
    set_brdf_uniforms(program);
    program.set("u_exponent", static_cast<float>(kMirrorExponent));
  };
  for (const float roughness : {0.0f, 1e-6f, 1e-3f, 0.05f, 0.1f, 0.3f, 0.5f, 0.9f, 1.0f})
    c.inputs.push_back({glm::vec4(roughness), {}});
  c.exact = [](const glm::dvec4& a, const glm::dvec4&) {
    const double variance = std::max(0.5 * std::pow(a.x, 4.0), 1.0 / (kMirrorExponent + 2.0));
    return glm::dvec4(variance, variance, 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Contains shader statements that set the basis functions of the normal up to order 2, as a file stores them.
constexpr char kFillHarmonics[] =
    "  vec3 n = a.xyz;\n"
    "  surface.parts[0] = a.w * vec4(0.48860251 * n.yzx, 1.09254843 * n.x * n.y);\n"
    "  surface.parts[1] = a.w * vec4(1.09254843 * n.y * n.z, 0.31539157 * (3.0 * n.z * n.z - 1.0),\n"
    "                                1.09254843 * n.z * n.x, 0.54627422 * (n.x * n.x - n.y * n.y));\n"
    "  surface.share = surface.material = a.w;\n  surface.albedo = vec3(1.0);\n";

void single_normals_as_harmonics(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr int kOrder = 2;
  const ZonalCoefficients of_brdf = zonal_blinn_phong(kOrder, kFacetExponent), of_lambert = zonal_lambert(kOrder);
  SurfaceTest test{kBlinnPhongFlags, std::string(shader_common_sh_shading_glsl) + shader_surface_sh_glsl,
                   kFillHarmonics, false};
  test.flags.push_back("MULTUM_ZONAL_ORDER 2");
  for (const std::string& flag : sh_shading_flags(kOrder)) test.flags.push_back(flag);
  const auto shaded = [&](const glm::dvec3& n, const glm::dvec3& w, const ZonalCoefficients& zonal) {
    return std::max(reference::shade_sh(reference::sh_basis_to(kOrder, n), 1.0, zonal, w), 0.0);
  };
  test.facets = [&](const glm::dvec3& n, const glm::dvec3& h) { return shaded(n, h, of_brdf); };
  test.diffuse = [&](const glm::dvec3& n, const glm::dvec3& l) { return shaded(n, l, of_lambert); };
  GlslComparison c = comparison_of(test);
  for (const double tilt : {0.0, 30.0, 89.0, 120.0, 180.0})
    for (const double degrees : {0.0, 45.0, 91.0, 150.0}) {
      c.inputs.push_back({with(tilted(tilt), 1.0), with(tilted(degrees, 1.0), 0.0)});
      c.inputs.push_back({glm::vec4(0.0f), with(tilted(degrees, 1.0), 0.0)});
    }
  c.variant.set_uniforms = [&](const ShaderProgram& program) {
    std::vector<glm::vec3> zonal;
    for (const double a : of_brdf) zonal.emplace_back(static_cast<float>(a));
    set_brdf_uniforms(program);
    program.set_vec3("u_zonal", glm::value_ptr(zonal[0]), kOrder + 1);
  };
  c.exact = [&](const glm::dvec4& a, const glm::dvec4& b) {
    if (a.w == 0.0) return glm::dvec4(0.0);
    const glm::dvec3 n(a), l(b);
    return glm::dvec4(test.diffuse(n, l), test.facets(n, half_vector(l, kView)) * std::max(glm::dot(n, l), 0.0), 0.0,
                      0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Tests equal light from every direction. A single normal reflects exactly this light, and an empty material reflects
// no light.
void compare_environment(const GlFunctions& gl, const Edits& edits, const SurfaceTest& test, WorstError& worst) {
  const ConstantLight light(gl);
  GlslComparison c{"", {}, {}};
  for (const double tilt : {0.0, 1e-4, 40.0, 60.0}) c.inputs.push_back({with(tilted(tilt), 1.0), {}});
  c.inputs.push_back({glm::vec4(0.0f), {}});
  const ShaderHarnessInput environment = environment_variant("");
  c.variant.flags = test.flags;
  c.variant.flags.insert(c.variant.flags.end(), environment.flags.begin(), environment.flags.end());
  c.variant.formulas = environment.formulas + test.texts +
                       "MultumReflection test_reflect(vec4 a) {\n  MultumSurface surface;\n" + test.fill +
                       "  multum_environment_frame = mat3(1.0);\n"
                       "  return multum_reflect_environment(surface, vec3(0.0, 0.0, 1.0));\n}\n";
  c.variant.set_uniforms = [&](const ShaderProgram& program) {
    set_brdf_uniforms(program);
    light.set(program);
  };
  for (const bool diffuse : {true, false}) {
    c.expression = fmt::format("vec4(test_reflect(a).{}, 0.0)", diffuse ? "diffuse" : "specular");
    c.exact = [&](const glm::dvec4& a, const glm::dvec4&) {
      return glm::dvec4(a.w * (diffuse ? ConstantLight::irradiance() : ConstantLight::highlight()), 0.0);
    };
    compare_glsl(gl, edits, c, worst);
  }
}

void lobes_in_an_environment(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  SurfaceTest test{kBlinnPhongFlags, lobe_texts(), "  surface.lobes[0] = a;\n", false};
  test.flags.push_back("MULTUM_LOBE_COUNT 1");
  compare_environment(gl, edits, test, worst);
}

void means_in_an_environment(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const char* mode : {"MULTUM_MIP", "MULTUM_TOKSVIG"}) {
    SurfaceTest test{kBlinnPhongFlags, shader_surface_normals_glsl,
                     "  surface.normal = a;\n  surface.albedo = vec3(1.0);\n  surface.weight = 1.0;\n", false};
    test.flags.push_back(mode);
    compare_environment(gl, edits, test, worst);
  }
}

// Tests light from all directions, and light that consists of two bands. Both depend only on E[n] and E[n n^T].
void harmonics_in_an_environment(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  SurfaceTest test{kBlinnPhongFlags, std::string(shader_common_sh_shading_glsl) + shader_surface_sh_glsl,
                   kFillHarmonics, false};
  test.flags.push_back("MULTUM_ZONAL_ORDER 2");
  for (const std::string& flag : sh_shading_flags(2)) test.flags.push_back(flag);
  compare_environment(gl, edits, test, worst);
  const SmoothLight light = {0.1, {0.3, -0.4, 1.0}};
  GlslComparison c{"vec4(test_irradiance(a), 0.0)", {}, {}};
  for (int i = 0; i <= 12; ++i) c.inputs.push_back({with(tilted(15.0 * i, 1.0 * i), 1.0), {}});
  const ShaderHarnessInput environment = environment_variant("");
  c.variant.flags = test.flags;
  c.variant.flags.insert(c.variant.flags.end(), environment.flags.begin(), environment.flags.end());
  c.variant.formulas = environment.formulas + test.texts +
                       "vec3 test_irradiance(vec4 a) {\n  MultumSurface surface;\n" + test.fill +
                       "  multum_environment_frame = mat3(1.0);\n  return multum_sh_irradiance(surface.parts);\n}\n";
  c.variant.set_uniforms = [&](const ShaderProgram& program) { set_smooth_light(program, light); };
  c.exact = [&](const glm::dvec4& a, const glm::dvec4&) {
    return glm::dvec4(glm::dvec3(std::max(light.irradiance(glm::dvec3(a)), 0.0)), 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// The columns must be perpendicular unit vectors for every tangent. If the tangent has a direction, the columns must
// keep it.
void tangents_along_the_normal(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslInputs inputs;
  for (const double tilt : {0.0, 50.0, 90.0, 180.0})
    for (const double length : {1e-6, 1.0, 1e6}) {
      const glm::dvec3 n = tilted(tilt), side = glm::normalize(glm::cross(n, glm::dvec3(0.3, 0.9, 0.1)));
      for (const glm::dvec3& tangent :
           {glm::dvec3(0.0), length * n, -length * n, length * side, length * (side + 3.0 * n)})
        for (const double hand : {1.0, -1.0}) inputs.emplace_back(with(length * n, 0.0), with(tangent, hand));
    }
  ShaderHarnessInput variant;
  variant.formulas =
      "vec4 test_lengths(mat3 f) { return vec4(length(f[0]), length(f[1]), length(f[2]), determinant(f)); }\n"
      "vec4 test_angles(mat3 f) { return vec4(dot(f[0], f[1]), dot(f[1], f[2]), dot(f[2], f[0]), 0.0); }\n";
  const auto add = [&](const std::string& function, const std::function<glm::dvec4(const glm::dvec4& b)>& exact) {
    compare_glsl(gl, edits,
                 {function + "(multum_tangent_frame(a.xyz, b))", inputs,
                  [&](const glm::dvec4&, const glm::dvec4& b) { return exact(b); }, false, variant},
                 worst);
  };
  add("test_lengths", [](const glm::dvec4& b) { return glm::dvec4(1.0, 1.0, 1.0, b.w); });
  add("test_angles", [](const glm::dvec4&) { return glm::dvec4(0.0); });
  GlslComparison c{"vec4(multum_tangent_frame(a.xyz, b)[0], 0.0)", {}, {}, false, variant};
  for (const auto& [a, b] : inputs)
    if (glm::length(glm::cross(glm::normalize(glm::dvec3(a)), glm::dvec3(b))) > 0.1 * glm::length(glm::dvec3(b)))
      c.inputs.emplace_back(a, b);
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const glm::dvec3 n = glm::normalize(glm::dvec3(a)), t(b);
    return glm::dvec4(glm::normalize(t - n * glm::dot(n, t)), 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

std::vector<GlslCase> environment_cases() {
  const std::string none = "a material without lobes reflects light from all directions, or gives NaN",
                    unit = "absolute error",
                    reason = "the result is the sum of nine equal texels, whose weights are rounded";
  return {
      {{"glsl-lobes-in-an-environment", "movmf.glsl", none, "lobes with amplitudes up to 1e-6 are ignored", 1e-4, unit,
        reason},
       {},
       lobes_in_an_environment,
       {"multum_reflect_environment"},
       {glsl_edit("reflection.specular = lobe.w * multum_environment_specular(mu, d, v);",
                  "reflection.specular = multum_environment_specular(mu, d, v);"),
        glsl_edit("if (lobe.w <= MULTUM_AMPLITUDE_MIN) return reflection;", "")}},
      {{"glsl-means-in-an-environment", "normals.glsl", none,
        "a material with a mean shorter than 1e-12 reflects nothing", 1e-4, unit, reason},
       {glsl_edit("if (length(mean) <= MULTUM_MEAN_MIN) return", "if (false) return")},
       means_in_an_environment,
       {"multum_reflect_environment"}},
      {{"glsl-harmonics-in-an-environment", "sh.glsl",
        "a series of only two bands becomes negative on the side opposite to a strong light",
        "the sum is at least 0, and a share of 0 reflects nothing", 1e-4, unit,
        "the expected value is a numerical integral, which has an error of its own"},
       {glsl_edit("return max(sum, vec3(0.0));", "return sum;")},
       harmonics_in_an_environment,
       {"multum_reflect_environment", "multum_sh_irradiance"}},
  };
}

}  // namespace

std::vector<GlslCase> glsl_surface_cases() {
  const std::string
      unit = "absolute error",
      behind = "light from straight behind and materials without lobes cause divisions of 0 by 0",
      reason = "the exponent 16 multiplies errors of 6e-8 in n and h, and the visibility is divided by cosines near 0";
  std::vector<GlslCase> cases = {
      {{"glsl-single-normals-as-lobes", "movmf.glsl", behind,
        "divisors are at least 1e-6, and the shader ignores lobes with amplitudes up to 1e-6", 2e-4, unit, reason},
       {glsl_edit("sum / max(length(sum), 1e-6)", "normalize(sum)")},
       single_normals_as_lobes,
       {"multum_reflect", "multum_lobe_visibility"}},
      {{"glsl-visibility-of-opposite-half-vectors", "movmf.glsl",
        "the shader computes the visibility with the mean of the lobe as n, but the facets that reflect light have "
        "normals near h",
        "n . h is computed with a direction between h and the mean, and if h and the mean cancel, the divisor is at "
        "least 1e-6",
        1e-2, unit,
        "the model of the mean cosine has an error of 0.22 % for both l and v, and the visibility can exceed 1"},
       {glsl_edit("multum_movmf_spread(lobe) * h + multum_movmf_mean_direction(lobe) / u_exponent",
                  "multum_movmf_mean_direction(lobe) / u_exponent")},
       visibility_of_opposite_half_vectors,
       {"multum_lobe_visibility"}},
      {{"glsl-single-normals-as-gaussians", "gmm.glsl",
        "the vector of an empty lobe is divided by the lobe's amplitude, which is 0", "the divisor is at least 1e-6",
        1e-3, unit,
        "the z of a mean near the unit circle is the square root of a number with a rounding error of 1.2e-7"},
       {glsl_edit("max(lobe.w, MULTUM_AMPLITUDE_MIN)", "lobe.w")},
       single_normals_as_gaussians,
       {"multum_reflect", "multum_gmm_visibility"}},
      {{"glsl-single-normals-as-means", "normals.glsl", "light from below the horizon makes the highlight negative",
        "cosines are at least 0, and a material with a mean shorter than 1e-12 reflects nothing", 2e-5, unit, reason},
       {glsl_edit("float n_l = max(dot(n, l), 0.0);", "float n_l = dot(n, l);")},
       single_normals_as_means,
       {"multum_mean_cosine", "multum_reflect_mean", "multum_reflect_texel", "multum_reflect"}},
      {{"glsl-exponents-of-roughness", "normals.glsl", "a roughness of 0 gives an infinite exponent",
        "the exponent is limited to the exponent that represents a mirror", 1e-6, unit,
        "a variance near 1/2 has a rounding error of at most 6e-8"},
       {glsl_edit("clamp(2.0 / max(alpha * alpha, 1e-12) - 2.0, 0.0, u_exponent)", "2.0 / (alpha * alpha) - 2.0")},
       exponents_of_roughness,
       {"multum_exponent", "multum_slope_exponent"}},
      {{"glsl-single-normals-as-harmonics", "sh.glsl", "the truncated series oscillates and makes the light negative",
        "the result is clamped at 0", 2e-5, unit, "only a few products are rounded in float"},
       {glsl_edit("return max(sum, 0.0);", "return sum;"), glsl_edit("return max(sum, vec3(0.0));", "return sum;")},
       single_normals_as_harmonics,
       {"multum_reflect"}},
      {{"glsl-tangents-along-the-normal", "reflection.glsl",
        "normalising a tangent that is parallel to the normal or has length 0 divides 0 by 0",
        "an arbitrary tangent perpendicular to the normal is used", 2e-6, unit,
        "only three square roots and a cross product are rounded"},
       {glsl_edit("if (dot(t, t) <= 1e-12 * max(dot(tangent.xyz, tangent.xyz), 1e-20))", "if (false)")},
       tangents_along_the_normal,
       {"multum_tangent_frame"}},
  };
  for (GlslCase& c : environment_cases()) cases.push_back(std::move(c));
  return cases;
}

}  // namespace multum::gl
