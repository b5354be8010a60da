// SPDX-License-Identifier: Apache-2.0
// The numerical cases of common/: planar Gaussians, moments, harmonics, pyramids and footprints, on what the kernels of
// the same formulas are tried with (host/selftest) and on what only a shader meets.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>

#include "host/asset/averages/spherical_harmonics.h"
#include "host/asset/pyramid/reflectance_mapping.h"
#include "host/reference/moments.h"
#include "host/reference/planar_em.h"
#include "host/reference/shading.h"
#include "host/reference/spherical_harmonics.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/gl/glsl_case_lists.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

// The third value as rounding and filtering may leave it: less than the square of the mean.
void planar_variance_below_0(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_gmm_density(a, b.xyz, b.w) / (b.w + 3.0))", {}, {}};
  for (const double degrees : {0.0, 30.0, 60.0, 89.0})
    for (const float missing : {0.0f, 1e-6f, 3e-5f, 5e-4f})
      for (const double s : {20.0, 500.0, 1e4})
        for (int i = -10; i <= 10; ++i) {
          const glm::vec3 p(tilted(degrees));
          c.inputs.push_back({{p.x, p.y, p.x * p.x + p.y * p.y - missing, 1.0f}, with(tilted(degrees + 2.0 * i), s)});
        }
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    return glm::dvec4(reference::gmm_density(a, b.w, glm::dvec3(b)) / (b.w + 3.0));
  };
  compare_glsl(gl, edits, c, worst);
}

// Means that rounding left outside the unit circle, and lobes of every amplitude there.
void planar_means_beyond_the_rim(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_gmm_lambert(a, b.xyz), multum_gmm_lifted(a.xy / max(a.w, 1e-6)))", {}, {}};
  for (const double length : {0.0, 0.5, 0.9999, 1.0, 1.0001, 1.5})
    for (const double amplitude : {1.0, 0.25})
      for (const double degrees : {0.0, 60.0, 120.0})
        c.inputs.push_back({with(amplitude * glm::dvec3(length, 0.0, 1.0), amplitude), with(tilted(degrees), 0.0)});
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double x = a.x / a.w, y = a.y / a.w, z = std::sqrt(std::max(1.0 - x * x - y * y, 0.0));
    return glm::dvec4(reference::gmm_lambert(a, glm::dvec3(b)), x, y, z);
  };
  compare_glsl(gl, edits, c, worst);
}

void planar_amplitude_to_0(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{
      "vec4(multum_gmm_density(a, b.xyz, b.w), multum_gmm_lambert(a, b.xyz), multum_gmm_variance(a), "
      "multum_gmm_mean(a).x)",
      {},
      {}};
  for (const float amplitude : {1e-6f, 1e-8f, 1e-30f, 1e-40f, 0.0f})
    c.inputs.push_back({glm::vec4(0.0f, 0.0f, 0.0f, amplitude), with(tilted(10.0), 100.0)});
  c.exact = [](const glm::dvec4&, const glm::dvec4&) { return glm::dvec4(0.0); };
  compare_glsl(gl, edits, c, worst);
}

// A mean normal, of which there may be none, as a Gaussian; and the facets' variance about means of every length.
void planar_mean_normals(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_gmm_normal_map(a).zw, multum_gmm_facet_variance(a, b.x), 0.0)", {}, {}};
  for (const double amplitude : {0.0, 1e-40, 1e-30, 1e-5, 0.5, 1.0})
    for (const double length : {0.0, 0.5, 1.0, 1.001})
      c.inputs.push_back({with(amplitude * length * tilted(80.0), amplitude), glm::vec4(100.0f)});
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double amplitude = std::max(a.w, 1e-6), square = (a.x * a.x + a.y * a.y) / (amplitude * amplitude);
    return glm::dvec4(a.w - a.z * a.z / amplitude, a.w, reference::facet_variance(b.x, square), 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Mean normals of every length, none at all and longer than 1 among them.
void toksvig_of_every_length(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const auto exponent_of = [](double length, double s) {
    const double size = std::min(length, 1.0);
    return s * size / (size + s * (1.0 - size));
  };
  GlslComparison c{"vec4(multum_moments_toksvig(a.xyz, b.xyz, b.w) / (b.w + 1.0))", {}, {}};
  for (const double length : {0.0, 1e-20, 1e-6, 0.5, 1.0 - 0x1p-20, 1.0, 1.0 + 0x1p-20, 1.001})
    for (const double s : {1.0, 20.0, 1000.0, 1e5})
      for (int i = 0; i < 20; ++i)
        c.inputs.push_back({with({0.0, 0.0, length}, 1.0),
                            with(tilted(89.0 * (i + 0.5) / 20.0 / std::sqrt(exponent_of(length, s) + 1.0)), s)});
  c.exact = [=](const glm::dvec4& a, const glm::dvec4& b) {
    const double theta = angle_between(glm::dvec3(b), {0.0, 0.0, 1.0});
    return glm::dvec4(a.z <= 1e-12 ? 0.0 : reference::blinn_phong(exponent_of(a.z, b.w), theta) / (b.w + 1.0));
  };
  compare_glsl(gl, edits, c, worst);
}

constexpr char kLean[] = "vec4(multum_moments_lean(a, b.w, b.xyz, u_exponent, false))";

ShaderHarnessInput of_exponent(double s) {
  ShaderHarnessInput variant;
  variant.set_uniforms = [s](const ShaderProgram& program) { program.set("u_exponent", static_cast<float>(s)); };
  return variant;
}

glm::vec4 half_at(double s, double t, double cross_moment) {
  return with(glm::normalize(glm::dvec3(-s, -t, 1.0)), cross_moment);
}

// Second moments below the square of the mean, of slopes up to the largest: no value is above the BRDF's own peak.
void slope_variance_below_0(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const double s : {1.0, 100.0, 1e5}) {
    GlslInputs inputs;
    for (const float mean : {0.0f, 0.5f, 3.0f, 20.0f})
      for (const float missing : {0.0f, 1e-7f, 1e-5f, 0.1f}) {
        const float square = mean * mean * (1.0f - missing) - (mean == 0.0f ? missing : 0.0f);
        const double at = static_cast<double>(mean), cross = -static_cast<double>(square);
        for (const glm::vec4& h : {half_at(at, -at, cross), half_at(0.0, 0.0, cross)})
          inputs.emplace_back(glm::vec4(mean, -mean, square, square), h);
      }
    const double peak = s / (2.0 * std::numbers::pi);
    const std::vector<glm::vec4> values = evaluate_glsl(gl, edits, kLean, inputs, of_exponent(s));
    double largest = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double value = static_cast<double>(values[i].x);
      worst.add((std::max(value - peak, 0.0) + std::max(-value, 0.0)) / peak + 0.0 * value,
                fmt::format("s {}, mean slope {}, second moment {}", s, inputs[i].first.x, inputs[i].first.z));
      largest = std::max(largest, value);
    }
    worst.add(largest, peak, peak, "the peak itself, of one slope");
  }
}

// Slopes along one line of the plane: Sigma has no determinant, and only the BRDF's own variance 1/s is across.
void slopes_along_a_line(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const double s : {10.0, 1e3, 1e5}) {
    GlslComparison c{kLean, {}, {}, true, of_exponent(s)};
    for (const float variance : {4.0f, 64.0f, 256.0f})
      for (const double sign : {1.0, -1.0})
        c.inputs.push_back({{0.0f, 0.0f, variance, variance}, half_at(0.0, 0.0, sign * static_cast<double>(variance))});
    c.exact = [=](const glm::dvec4& a, const glm::dvec4& b) {
      reference::TexelMoments m;
      m.ss = a.z, m.tt = a.w, m.st = b.w;
      return glm::dvec4(reference::lean(m, glm::dvec3(b), s, false));
    };
    compare_glsl(gl, edits, c, worst);
  }
}

// Steep slopes nearly alike under a sharp highlight, as in host/selftest/moment_cases.cpp.
void steep_and_sharp(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const double s : {100.0, 1e3, 1e4, 1e5}) {
    GlslInputs inputs;
    std::vector<double> exact, scales;
    for (const double slope : {0.1, 1.0, 5.0, 20.0})
      for (const double variance : {0.0, 1e-6, 1e-4})
        for (const double off : {0.0, std::sqrt(variance + 1.0 / s)}) {
          reference::TexelMoments m;
          m.s = slope, m.t = -slope, m.st = -slope * slope;
          m.ss = m.tt = slope * slope + variance;
          inputs.emplace_back(glm::vec4(glm::dvec4(m.s, m.t, m.ss, m.tt)), half_at(slope + off, -slope, m.st));
          exact.push_back(reference::lean(m, glm::dvec3(inputs.back().second), s, false));
          scales.push_back(s / (2.0 * std::numbers::pi) *
                           (1e-6 + 0x1p-22 * (s * slope * slope + std::sqrt(s) * (1.0 + slope))));
        }
    const std::vector<glm::vec4> values = evaluate_glsl(gl, edits, kLean, inputs, of_exponent(s));
    for (std::size_t i = 0; i < values.size(); ++i)
      worst.add(static_cast<double>(values[i].x), exact[i], scales[i],
                fmt::format("s {}, slope {}, second moment {}", s, inputs[i].first.x, inputs[i].first.z));
  }
}

// Half vectors at and below the horizon, where a slope and the Jacobian have no bound.
void half_vectors_at_the_horizon(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslInputs inputs;
  for (const double z : {1e-4, 1e-20, 1e-40, 0.0, -0.0, -1e-3, -1.0})
    inputs.emplace_back(glm::vec4(-20.0f, 0.0f, 400.0f, 0.0f), with({std::sqrt(1.0 - z * z), 0.0, z}, 0.0));
  for (const char* jacobian : {"false", "true"}) {
    const std::string text = fmt::format("vec4(multum_moments_lean(a, b.w, b.xyz, 100.0, {}))", jacobian);
    for (const glm::vec4& value : evaluate_glsl(gl, edits, text, inputs, {}))
      worst.add(static_cast<double>(value.x), fmt::format("z and {}", jacobian));
  }
}

constexpr int kUnrolledOrder = 4;  // 20 is tests/agreement's; compilers take loops apart

// Coefficients of each set of directions, and what shades them; the texture has a row a set.
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

// Both shading functions against the series in double, at the poles too, over the peak of one tilt.
void harmonics_of_opposite_tilts(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  for (const double s : {12.0, 500.0}) {
    const ZonalCoefficients of_brdf = zonal_blinn_phong(kUnrolledOrder, s), of_lambert = zonal_lambert(kUnrolledOrder);
    Harmonics h = harmonics_of(gl, kUnrolledOrder, of_brdf);
    h.variant.texture = &h.map;
    const double peak = reference::shade_sh(mean_basis(kUnrolledOrder, h.sets[0]), 1.0, of_brdf, h.sets[0][0]);
    GlslComparison c{"vec4(test_facets(a.xyz, a.w) / u_facet_total.x, test_lambert(a.xyz, a.w), 0.0, 0.0)",
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
      return glm::dvec4(shaded(of_brdf) / peak, shaded(of_lambert), 0.0, 0.0);
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

// E[n] and E[n n^T]; of order 1, which has no second moments, as if all directions were alike.
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

ShaderHarnessInput pyramid_variant() {
  ShaderHarnessInput variant;
  variant.formulas = shader_common_pyramid_glsl;
  return variant;
}

// Of every width, about every direction, also straight down, where tangents are chosen anew.
void normals_drawn(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_movmf_drawn_normal(a, b.xy), 0.0)", {}, {}};
  for (const double tilt : {0.0, 40.0, 90.0, 140.0, 180.0})
    for (const float spread : {-1e-4f, 0.0f, 1e-6f, 0.1f, 0.9f, 1.0f})
      for (const float x : {0.0f, 0.3f, 0.9f, 0.9999999f, 1.0f})
        for (const float y : {0.0f, 0.4f})
          c.inputs.push_back({with(static_cast<double>(1.0f - spread) * tilted(tilt), 1.0), {x, y, 0.0f, 0.0f}});
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double size = glm::length(glm::dvec3(a)), d = std::clamp(1.0 - size, 0.0, 1.0);
    const glm::dvec3 mu = size > 1e-12 ? glm::dvec3(a) / size : glm::dvec3(0.0, 0.0, 1.0);
    const double kappa = d <= 0.0 ? 1e12 : d >= 1.0 ? 1e-3 : std::max(reference::vmf_kappa(d), 1e-3);
    const double e = std::clamp(-std::log(std::max(1.0 - b.x * -std::expm1(-2.0 * kappa), 1e-30)) / kappa, 0.0, 2.0);
    const double side = mu.z < 0.0 ? -1.0 : 1.0, q = -1.0 / (side + mu.z), r = mu.x * mu.y * q;
    const glm::dvec3 s(1.0 + side * mu.x * mu.x * q, side * r, -side * mu.x), t(r, side + mu.y * mu.y * q, -mu.y);
    const double phi = 2.0 * M_PI * b.y;
    return glm::dvec4((1.0 - e) * mu + std::sqrt(e * (2.0 - e)) * (std::cos(phi) * s + std::sin(phi) * t), 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Every frame of a pixel, also where a float has no fraction left; `map` holds quarters.
void numbers_of_the_millionth_frame(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr int kSide = 64;
  std::vector<float> texels;
  for (int i = 0; i < kSide * kSide; ++i)
    for (int c = 0; c < 4; ++c) texels.push_back(0.25f * static_cast<float>((i + i / kSide + c) % 4));
  Texture noise(gl, "noise", {kSide, kSide, 1, TexelFormat::kRgba32f},
                {WrapMode::kClamp, WrapMode::kClamp, true, 1.0f});
  noise.upload_level(0, texels.data());
  GlslComparison c{"vec4(multum_blue_noise(map, a.xy, b.x), 0.0)", {}, {}};
  for (const float x : {0.0f, 0.5f, 63.9f, 64.0f, 1919.5f})
    for (const float y : {0.5f, 70.0f, 1079.5f})
      for (const float frame : {0.0f, 1.0f, 1023.0f, 1024.0f, 1030.0f, 1000003.0f, 16777215.0f})
        c.inputs.push_back({{x, y, 0.0f, 0.0f}, {frame, 0.0f, 0.0f, 0.0f}});
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double steps[] = {0.618033988749895, 0.754877666246693, 0.569840290998053}, count = std::fmod(b.x, 1024.0);
    const int column = static_cast<int>(a.x) % kSide, row = static_cast<int>(a.y) % kSide;
    glm::dvec4 numbers(0.0);
    for (int k = 0; k < 3; ++k) {
      const double texel = 0.25 * ((row * kSide + column + row + k) % 4);
      const double place = texel * 255.0 / 256.0 + count * steps[k];
      numbers[k] = place - std::floor(place);
    }
    return numbers;
  };
  c.variant.texture = &noise;
  c.variant.formulas = shader_common_blue_noise_glsl;
  compare_glsl(gl, edits, c, worst);
}

void level_of_no_extent(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_mip_level(a.xy, b.xy), 0.0, 0.0, 0.0)", {}, {}};
  for (const float x : {0.0f, 1e-40f, 1e-20f, 1e-8f, 1.0f, 1e4f, 1e15f})
    for (const float y : {0.0f, 1e-8f, 1.0f, 1e15f}) c.inputs.push_back({{x, 0.0f, 0.0f, 0.0f}, {y, y, 0.0f, 0.0f}});
  c.variant = pyramid_variant();
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    return glm::dvec4(0.5 * std::log2(std::max({a.x * a.x, b.x * b.x + b.y * b.y, 1e-30})), 0.0, 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// From the viewer's direction to straight away from it, where every corner of the map is meant.
void normals_straight_away(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_reflectance_place(a.xyz), 0.0, 0.0)", {}, {}};
  for (const double degrees : {0.0, 1e-4, 30.0, 89.999, 90.0, 90.001, 150.0, 179.0, 179.99, 179.9999, 179.999999})
    for (const double azimuth : {0.0, 0.3, 2.0, 4.0}) c.inputs.push_back({with(tilted(degrees, azimuth), 0.0), {}});
  c.inputs.push_back({{0.0f, 0.0f, -1.0f, 0.0f}, {}});
  c.inputs.push_back({{-0.0f, -0.0f, -1.0f, 0.0f}, {}});
  c.variant = pyramid_variant();
  c.exact = [](const glm::dvec4& a, const glm::dvec4&) {
    return glm::dvec4(reflectance_place({}, glm::dvec3(a)), 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

int wrapped(int i, int size, int mode) {
  if (mode == 1) return std::clamp(i, 0, size - 1);
  if (mode == 0) return i >= 0 && i < size ? i : -1;
  const int period = mode == 2 ? size : 2 * size, at = ((i % period) + period) % period;
  return at < size ? at : period - 1 - at;
}

ShaderHarnessInput footprint_variant(int sample, int wrap) {
  ShaderHarnessInput variant;
  variant.flags = {"MULTUM_REFERENCE"};
  variant.formulas = shader_common_footprint_glsl;
  variant.set_uniforms = [=](const ShaderProgram& program) {
    program.set("u_sample", sample);
    program.set("u_wrap_s", wrap);
    program.set("u_wrap_t", wrap);
  };
  return variant;
}

void texels_far_outside(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(float(multum_wrapped(int(a.x), int(b.x), int(b.y))), 0.0, 0.0, 0.0)", {}, {}};
  for (const int size : {1, 2, 3, 37, 4096})
    for (const int mode : {0, 1, 2, 3})
      for (const int i :
           {0, 1, -1, size - 1, size, -size, -size - 1, 2 * size, 2 * size - 1, -2 * size, 8388607, -8388607})
        c.inputs.push_back(
            {glm::vec4(static_cast<float>(i)), {static_cast<float>(size), static_cast<float>(mode), 0.0f, 0.0f}});
  c.variant = footprint_variant(0, 0);
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const int texel = wrapped(static_cast<int>(a.x), static_cast<int>(b.x), static_cast<int>(b.y));
    return glm::dvec4(texel, 0.0, 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

std::uint32_t hash(std::uint32_t v) {
  const std::uint32_t state = v * 747796405u + 2891336453u;
  const std::uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

// The pixel's own number is that of the element.
void places_of_the_billionth_sample(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr std::uint32_t kSteps[] = {3859688306u, 3468523225u, 3117001274u, 2801104767u, 2517223198u, 2262111973u};
  for (const int sample : {0, 1, 1000003, 2147483647}) {
    GlslInputs inputs;
    for (std::uint32_t i = 0; i < 100; ++i) inputs.emplace_back(glm::vec4(), glm::vec4(static_cast<float>(i % 6)));
    const std::vector<glm::vec4> found =
        evaluate_glsl(gl, edits, "vec4(multum_random(int(b.x)), 0.0, 0.0, 0.0)", inputs, footprint_variant(sample, 0));
    for (std::uint32_t i = 0; i < 100; ++i) {
      const std::uint32_t n = i % 6, place = hash(i + hash(hash(n))) + static_cast<std::uint32_t>(sample) * kSteps[n];
      worst.add(static_cast<double>(found[i].x), static_cast<double>(place >> 8u) / 16777216.0, 1.0,
                fmt::format("sample {}, coordinate {}", sample, n));
    }
  }
}

// Texels that a filter mixes at one place, inside and far outside, are the only ones that are drawn.
void footprints_of_one_place(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr int kWidth = 37, kHeight = 21;
  constexpr WrapMode kModes[] = {WrapMode::kBlack, WrapMode::kClamp, WrapMode::kPeriodic, WrapMode::kMirror};
  for (const int mode : {0, 1, 2, 3})
    for (const glm::vec2& st : {glm::vec2(0.0f, 0.999999f), glm::vec2(-3.3f, 17.25f)}) {
      const Texture map(gl, "map", {kWidth, kHeight}, {kModes[mode], kModes[mode], true, 1.0f});
      ShaderHarnessInput variant = footprint_variant(7, mode);
      variant.texture = &map;
      variant.formulas += "uniform vec2 u_place;\n";
      variant.set_uniforms = [&st, set = variant.set_uniforms](const ShaderProgram& program) {
        set(program);
        program.set_vec2("u_place", &st.x);
      };
      for (const glm::vec4& found : evaluate_glsl(
               gl, edits,
               "vec4(vec2(multum_footprint_texel(map, u_place, MultumFootprint(vec2(0.0), 1, 0.0))), 0.0, 0.0)",
               GlslInputs(64), variant)) {
        bool is_one = false;
        for (int corner = 0; corner < 4; ++corner) {
          const glm::vec2 place = st * glm::vec2(kWidth, kHeight) - 0.5f;
          const int x = wrapped(static_cast<int>(std::floor(place.x)) + corner % 2, kWidth, mode),
                    y = wrapped(static_cast<int>(std::floor(place.y)) + corner / 2, kHeight, mode);
          const glm::vec2 texel = x < 0 || y < 0 ? glm::vec2(-1.0f) : glm::vec2(x, y);
          is_one = is_one || texel == glm::vec2(found);
        }
        worst.add(is_one ? 0.0 : 1.0,
                  fmt::format("mode {}, ({}, {}): texel ({}, {})", mode, st.x, st.y, found.x, found.y));
      }
    }
}

// What the shader does with two derivatives, in double.
glm::dvec4 exact_footprint(const glm::dvec4& a, int taps_max, double size, double bias) {
  const glm::dvec2 along_x(a.x, a.y), along_y(a.z, a.w);
  const double x = glm::length(along_x), y = glm::length(along_y), longer = std::max(x, y), shorter = std::min(x, y);
  const double ratio = shorter > 0.0 ? longer / shorter : longer > 0.0 ? 1e30 : 0.0;
  const double count = std::max(std::ceil(std::min(ratio, static_cast<double>(taps_max)) - 1e-3), 1.0);
  const glm::dvec2 step = (x > y ? along_x : along_y) / (size * count);
  const double width = count == 1.0 ? longer : std::max(shorter, longer / count * std::exp2(-0.75));
  return glm::dvec4(step, count, std::log2(std::max(width, 1e-15)) + bias);
}

ShaderHarnessInput filter_variant(int taps_max, float bias) {
  ShaderHarnessInput variant;
  variant.flags = {"MULTUM_TAPS " + std::to_string(taps_max)};
  variant.set_uniforms = [bias](const ShaderProgram& program) { program.set("u_level_bias", bias); };
  return variant;
}

// Round, long, one-dimensional and empty footprints; ratios just beside whole numbers.
void footprints_of_no_width(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr float kSize = 64.0f, kBias = -0.5f;
  for (const int taps_max : {1, 4, 16}) {
    GlslComparison c{"test_footprint(a)", {}, {}};
    for (const float x : {0.0f, 1e-12f, 0.25f, 1.0f, 3.0f, 1e4f})
      for (const float ratio : {0.0f, 0.05f, 0.3333333f, 0.5f, 0.52f, 1.0f}) {
        c.inputs.push_back({{x, 0.0f, 0.0f, ratio * x}, {}});
        c.inputs.push_back({{0.6f * ratio * x, 0.8f * ratio * x, -0.8f * x, 0.6f * x}, {}});
      }
    c.variant = filter_variant(taps_max, kBias);
    c.variant.formulas =
        "vec4 test_footprint(vec4 a) {\n  MultumFootprint f = multum_footprint_of(a.xy, a.zw, vec2(64.0));\n"
        "  return vec4(f.tap_step, float(f.tap_count), f.level);\n}\n";
    c.exact = [=](const glm::dvec4& a, const glm::dvec4&) {
      return exact_footprint(a, taps_max, static_cast<double>(kSize), static_cast<double>(kBias));
    };
    compare_glsl(gl, edits, c, worst);
  }
}

// Of the first level of a map that keeps every second octave.
void footprints_on_another_size(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"test_other(a)", {}, {}};
  for (const float from : {1.0f, 37.0f, 64.0f, 4096.0f})
    for (const float to : {1.0f, 16.0f, 148.0f, 4096.0f}) c.inputs.push_back({{from, to, 1.5f, 0.0f}, {}});
  c.variant = filter_variant(4, 0.0f);
  c.variant.formulas =
      "vec4 test_other(vec4 a) {\n  MultumFootprint f = multum_footprint_on(MultumFootprint(vec2(0.1, 0.2), 3, a.z),\n"
      "      ivec2(int(a.x), 1), ivec2(1, int(a.y)));\n"
      "  return vec4(f.tap_step, float(f.tap_count), f.level);\n}\n";
  c.exact = [](const glm::dvec4& a, const glm::dvec4&) {
    return glm::dvec4(static_cast<double>(0.1f), static_cast<double>(0.2f), 3.0, a.z + std::log2(a.y / a.x));
  };
  compare_glsl(gl, edits, c, worst);
}

std::vector<GlslCase> filter_cases() {
  const std::string file = "texture_filter.glsl";
  return {
      {{"glsl-footprints-of-no-width", file, "a length of 0 divides, and has no logarithm", "lengths of at least 1e-15",
        2e-4, "absolute, of steps, taps and levels", "the GL's log2, of numbers down to 1e-15"},
       {glsl_edit("log2(max(width, 1e-15))", "log2(width)")},
       footprints_of_no_width,
       {"multum_footprint_of"}},
      {{"glsl-footprints-on-another-size", file, "the level of one texture taken for another's",
        "the octaves between their longer sides are added", 1e-4, "absolute, of levels", "the GL's log2"},
       {glsl_edit("footprint.level + octaves", "footprint.level")},
       footprints_on_another_size,
       {"multum_footprint_on"}},
  };
}

std::vector<GlslCase> planar_cases() {
  const std::string file = "gmm_shading.glsl";
  return {
      {{"glsl-planar-filtered-variance-below-0", file,
        "rounding and filtering leave less than the square of the mean: the variance is negative",
        "no variance but the facets' own", 2e-3, "of an upright lobe's peak, times 2 pi",
        "6e-8 of a mean near 1, twice, against a variance of 1e-4"},
       {glsl_edit("max(0.5 * (lobe.z - dot(mean, lobe.xy)) / max(lobe.w, MULTUM_AMPLITUDE_MIN), 0.0)",
                  "(0.5 * (lobe.z - dot(mean, lobe.xy)) / max(lobe.w, MULTUM_AMPLITUDE_MIN))")},
       planar_variance_below_0,
       {"multum_gmm_mean", "multum_gmm_variance", "multum_gmm_facet_variance", "multum_gmm_density"}},
      {{"glsl-planar-means-beyond-the-rim", file, "a mean outside the circle is lifted to the root of less than 0",
        "to the equator", 1e-3, "absolute", "the root of 1.2e-7, of a mean on the circle"},
       {glsl_edit("sqrt(max(1.0 - dot(p, p), 0.0))", "sqrt(1.0 - dot(p, p))")},
       planar_means_beyond_the_rim,
       {"multum_gmm_lifted", "multum_gmm_lambert"}},
      {{"glsl-planar-amplitude-to-0", file, "a lobe of no normals is divided by its amplitude: 0 / 0",
        "no lobe at or below 1e-6", kNothingWrong, "absolute", "nothing may be"},
       {glsl_edit("max(lobe.w, MULTUM_AMPLITUDE_MIN)", "lobe.w")},
       planar_amplitude_to_0,
       {"multum_gmm_density", "multum_gmm_lambert"}},
      {{"glsl-planar-mean-normals", file, "a mean of no normals is divided by its share: 0 / 0",
        "shares of at least 1e-6 divide", 1e-6, "absolute", "two products and a quotient"},
       {glsl_edit("mean.z * mean.z / max(mean.w, MULTUM_AMPLITUDE_MIN)", "mean.z * mean.z / mean.w")},
       planar_mean_normals,
       {"multum_gmm_normal_map", "multum_gmm_facet_variance"}},
  };
}

std::vector<GlslCase> moment_cases() {
  const std::string file = "moment_shading.glsl";
  return {
      {{"glsl-mean-normals-of-every-length", file, "longer than 1: a gloss above 1 or below 0; of no length: 0 / 0",
        "1 less the length is at least 0; nothing where there is no length", 1e-5, "of the peak, times 2 pi",
        "6e-8 of mu and h, by the angle that the exponent sees"},
       {glsl_edit("max(1.0 - size, 0.0)", "(1.0 - size)")},
       toksvig_of_every_length,
       {"multum_moments_toksvig"}},
      {{"glsl-slope-variance-below-0", file, "E[s^2] below the square of E[s]: a negative determinant has no root",
        "variances of at least 0", 2e-6, "of the peak: how far above it, or below 0",
        "a root, a division and an exponential"},
       {glsl_edit("max(slopes.zw - slopes.xy * slopes.xy, vec2(0.0))", "(slopes.zw - slopes.xy * slopes.xy)")},
       slope_variance_below_0,
       {"multum_moments_lean"}},
      {{"glsl-slopes-along-a-line", file,
        "the determinant of Sigma + I/s as a difference: s = 1e5 leaves nothing of it",
        "1/s (1/s + trace) and the determinant of Sigma, held at 0 and above", 5e-6, "relative",
        "a root, a division and four products"},
       {glsl_edit("base * (base + variance.x + variance.y) +\n"
                  "                      max(variance.x * variance.y - covariance * covariance, 0.0)",
                  "(base + variance.x) * (base + variance.y) - covariance * covariance")},
       slopes_along_a_line},
      {{"glsl-steep-slopes-under-sharp-highlights", file,
        "moments in half floats: 400 to the next 0.25, where s = 1e5 has 1e-5",
        "32-bit moments; what they lose broadens the highlight by 2^-22 s b^2 of its width at most", 1.0,
        "of the peak, over 2^-22 (s b^2 + sqrt(s) (1 + b)) + 1e-6, b the slope",
        "E[s^2] and E[s]^2 are rounded, 2^-24 b^2 each"},
       {glsl_edit("max(slopes.zw - slopes.xy * slopes.xy, vec2(0.0))",
                  "max(floor(slopes.zw * 4.0 + 0.5) * 0.25 - slopes.xy * slopes.xy, vec2(0.0))")},
       steep_and_sharp},
      {{"glsl-half-vectors-at-the-horizon", file, "the slope of a half vector at the horizon: inf - inf",
        "nothing at or below 1e-4 above it", kNothingWrong, "absolute, where nothing is to be", "nothing may be"},
       {glsl_edit("if (h.z <= 1e-4) return 0.0;", "")},
       half_vectors_at_the_horizon},
  };
}

std::vector<GlslCase> harmonic_cases() {
  const std::string file = "sh_shading.glsl";
  return {
      {{"glsl-harmonics-of-opposite-tilts", file, "a direction that is not made unit, or a mean of none, has no lobes",
        "none is needed: the series has both, at the poles too", 2e-5, "of the peak of one tilt",
        "that of the basis, twice, in proportion to a_l"},
       {glsl_edit("float rotated = c * w.x - s * w.y;", "float rotated = c * w.x;")},
       harmonics_of_opposite_tilts,
       {"multum_sh_coefficient", "multum_sh_bands", "multum_sh_facets", "multum_sh_lambert"}},
      {{"glsl-harmonics-ring-below-0", file, "a series that ends rings: light below 0 darkens what is beside it",
        "clamped at 0", kNothingWrong, "absolute, of what is below 0", "nothing may be"},
       {glsl_edit("return max(sum, vec3(0.0));\n}", "return sum;\n}")},
       harmonics_ring_below_0},
      {{"glsl-moments-of-harmonics", file, "E[n n^T] without its mean, 1/3 of the unit matrix",
        "the trace is 1; order 1 has no more than that", 1e-6, "absolute", "three sums of some floats"},
       {glsl_edit("(parts[1].y / 0.31539157 + 1.0) / 3.0", "(parts[1].y / 0.31539157) / 3.0")},
       moments_of_harmonics,
       {"multum_sh_mean_normal", "multum_sh_second_moments"}},
  };
}

}  // namespace

std::vector<GlslCase> glsl_common_cases() {
  std::vector<GlslCase> cases = {
      {{"glsl-normals-drawn-from-any-lobe", "movmf_shading.glsl",
        "a root of less than 0, where rounding draws beyond the direction opposite", "1 - cosine within 0 and 2", 3e-2,
        "absolute, of a unit vector", "of a lobe that fills the sphere the logarithm of nearly 1"},
       {glsl_edit("clamp(-log(max(1.0 - xi.x * (1.0 - exp(-2.0 * kappa)), 1e-30)) / kappa, 0.0, 2.0)",
                  "(-log(max(1.0 - xi.x * (1.0 - exp(-2.0 * kappa)), 1e-30)) / kappa)")},
       normals_drawn,
       {"multum_movmf_drawn_normal"}},
      {{"glsl-numbers-of-the-millionth-frame", "blue_noise.glsl",
        "the fraction of a large product in float is lost: all frames draw alike", "frames counted modulo 1024", 1e-4,
        "absolute", "6e-5 of a product of 772"},
       {glsl_edit("frame - MULTUM_BLUE_NOISE_FRAMES * floor(frame / MULTUM_BLUE_NOISE_FRAMES)", "frame")},
       numbers_of_the_millionth_frame,
       {"multum_blue_noise"}},
      {{"glsl-level-of-no-extent", "pyramid.glsl", "the logarithm of 0, where coordinates do not change",
        "squares of at least 1e-30", 1e-4, "absolute, of the level", "the GL's log2"},
       {glsl_edit("max(max(dot(along_x, along_x), dot(along_y, along_y)), 1e-30)",
                  "max(dot(along_x, along_x), dot(along_y, along_y))")},
       level_of_no_extent,
       {"multum_mip_level"}},
      {{"glsl-normals-straight-away", "pyramid.glsl", "1 + z cancels, and a normal straight away lies at 0 / 0",
        "the projection's length from 1 - z; a corner where there is no direction", 1e-4, "absolute, of s and t",
        "6e-8 of n_z at 90 degrees; elsewhere some roundings"},
       {glsl_edit("if (n.z > 0.0) return", "if (true) return")},
       normals_straight_away,
       {"multum_reflectance_place"}},
      {{"glsl-texels-far-outside", "footprint.glsl", "a quotient cut off towards 0: texels left of the map are others",
        "rounded down", kNothingWrong, "texels", "whole numbers"},
       {glsl_edit("(i >= 0 ? i / period : -1 - (-1 - i) / period)", "(i / period)")},
       texels_far_outside,
       {"multum_wrapped"}},
      {{"glsl-places-of-the-billionth-sample", "footprint.glsl",
        "the fraction of a large product in float is lost: all samples lie at one place",
        "products modulo 2^32 in whole numbers", kNothingWrong, "absolute", "not a bit may differ"},
       {glsl_edit("float((pixel + uint(u_sample) * steps[n]) >> 8u) / 16777216.0",
                  "fract(float(pixel) / 4294967296.0 + float(u_sample) * (float(steps[n]) / 4294967296.0))")},
       places_of_the_billionth_sample,
       {"multum_hash", "multum_random"}},
      {{"glsl-footprints-of-one-place", "footprint.glsl", "a texel beyond a black border is read", "none is named",
        kNothingWrong, "texels wrong", "none may be"},
       {glsl_edit("if (min(texel.x, texel.y) < 0) return MULTUM_NO_TEXEL;", "")},
       footprints_of_one_place,
       {"multum_footprint_texel"}},
  };
  for (auto* part : {filter_cases, planar_cases, moment_cases, harmonic_cases})
    for (GlslCase& c : part()) cases.push_back(std::move(c));
  return cases;
}

}  // namespace multum::gl
