// SPDX-License-Identifier: Apache-2.0
// Defines the numerical cases of planar Gaussians and of slope moments. The inputs include those of the kernels that
// use the same formulas (host/lab/selftest), and inputs that occur only in shaders.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/lab/reference/moments.h"
#include "host/lab/reference/planar_em.h"
#include "host/lab/reference/shading.h"
#include "runtime_gl/materials/sh_material.h"
#include "tests/gl/glsl/case_lists.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

// Tests lobes whose third value is below the square of the mean. Rounding and filtering can produce these lobes.
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

// Tests lobes of every amplitude whose means are outside the unit circle because of rounding.
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

// Tests the Gaussian of a mean normal. The mean normal can have any length, including 0. Also tests the facet variance
// of such means.
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

// Tests mean normals from length 0 to longer than 1.
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

// Tests second moments below the square of the mean, for slopes up to the largest allowed slope. No value exceeds the
// peak of the BRDF.
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

// Tests slopes along one line of the plane. The determinant of Sigma is 0, and across the line only the BRDF's own
// variance 1/s remains.
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

// Tests steep and nearly equal slopes under a sharp highlight, as in host/lab/selftest/moment_cases.cpp.
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

// Tests half vectors at and below the horizon, where the slope and the Jacobian are unbounded.
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

std::vector<GlslCase> gaussian_cases() {
  const std::string file = "gmm_shading.glsl";
  return {
      {{"glsl-planar-filtered-variance-below-0", file,
        "rounding and filtering make the mean square smaller than the squared mean, so the variance is negative",
        "the lobe's variance is at least 0, so in the worst case only the facets' variance remains", 2e-3,
        "of 2 pi times the peak of an upright lobe",
        "a mean near 1 is rounded twice, which changes a variance of 1e-4 by up to 1.2e-7, or 0.12 %"},
       {glsl_edit("max(0.5 * (lobe.z - dot(mean, lobe.xy)) / max(lobe.w, MULTUM_AMPLITUDE_MIN), 0.0)",
                  "(0.5 * (lobe.z - dot(mean, lobe.xy)) / max(lobe.w, MULTUM_AMPLITUDE_MIN))")},
       planar_variance_below_0,
       {"multum_gmm_mean", "multum_gmm_variance", "multum_gmm_facet_variance", "multum_gmm_density"}},
      {{"glsl-planar-means-beyond-the-rim", file,
        "the z of a mean outside the unit circle is the square root of a negative number",
        "the shader moves the mean to the equator", 1e-3, "absolute error",
        "the z of a mean on the unit circle is the square root of a rounding error of 1.2e-7"},
       {glsl_edit("sqrt(max(1.0 - dot(p, p), 0.0))", "sqrt(1.0 - dot(p, p))")},
       planar_means_beyond_the_rim,
       {"multum_gmm_lifted", "multum_gmm_lambert"}},
      {{"glsl-planar-amplitude-to-0", file,
        "the vector of an empty lobe is divided by the lobe's amplitude, which is 0",
        "lobes with amplitudes up to 1e-6 are ignored", kNothingWrong, "absolute error", "the result must be exact"},
       {glsl_edit("max(lobe.w, MULTUM_AMPLITUDE_MIN)", "lobe.w")},
       planar_amplitude_to_0,
       {"multum_gmm_density", "multum_gmm_lambert"}},
      {{"glsl-planar-mean-normals", file, "the mean normal of an empty level is divided by its share, which is 0",
        "the divisor is at least 1e-6", 1e-6, "absolute error", "only two products and a quotient are rounded"},
       {glsl_edit("mean.z * mean.z / max(mean.w, MULTUM_AMPLITUDE_MIN)", "mean.z * mean.z / mean.w")},
       planar_mean_normals,
       {"multum_gmm_normal_map", "multum_gmm_facet_variance"}},
  };
}

std::vector<GlslCase> moment_cases() {
  const std::string file = "moment_shading.glsl";
  return {
      {{"glsl-mean-normals-of-every-length", file,
        "a mean normal longer than 1 gives a gloss above 1 or below 0, and normalising a mean of length 0 divides 0 by "
        "0",
        "the shader uses max(1 - length, 0), and a mean of length 0 reflects nothing", 1e-5, "of 2 pi times the peak",
        "the mean direction mu and the half vector h have rounding errors of up to 6e-8, which the exponent "
        "multiplies"},
       {glsl_edit("max(1.0 - size, 0.0)", "(1.0 - size)")},
       toksvig_of_every_length,
       {"multum_moments_toksvig"}},
      {{"glsl-slope-variance-below-0", file,
        "rounding makes the mean squared slope smaller than the square of the mean slope, and the root of the negative "
        "determinant is NaN",
        "variances are at least 0", 2e-6, "amount of light above the peak or below 0, relative to the peak,",
        "only three operations are rounded: a square root, a division and an exponential"},
       {glsl_edit("max(slopes.zw - slopes.xy * slopes.xy, vec2(0.0))", "(slopes.zw - slopes.xy * slopes.xy)")},
       slope_variance_below_0,
       {"multum_moments_lean"}},
      {{"glsl-slopes-along-a-line", file,
        "if the determinant of Sigma + I/s (Sigma is the covariance) is computed as a difference, it has no correct "
        "digit at exponent s = 1e5",
        "the determinant of Sigma is kept at or above 0, and the positive term 1/s (1/s + trace) is added to it", 5e-6,
        "relative error", "only a square root, a division and four products are rounded"},
       {glsl_edit("base * (base + variance.x + variance.y) +\n"
                  "                      max(variance.x * variance.y - covariance * covariance, 0.0)",
                  "(base + variance.x) * (base + variance.y) - covariance * covariance")},
       slopes_along_a_line},
      {{"glsl-steep-slopes-under-sharp-highlights", file,
        "16-bit floats near 400 have steps of 0.25, but a highlight with exponent s = 1e5 needs moments in steps of "
        "1e-5",
        "moments are stored in 32 bits, so rounding widens a highlight at slope b by at most 2^-22 s b^2 times its "
        "width",
        1.0, "times the allowed error, which is 2^-22 (s b^2 + sqrt(s) (1 + b)) + 1e-6 of the peak at slope b",
        "the mean squared slope and the square of the mean slope each have a rounding error of up to 2^-24 b^2"},
       {glsl_edit("max(slopes.zw - slopes.xy * slopes.xy, vec2(0.0))",
                  "max(floor(slopes.zw * 4.0 + 0.5) * 0.25 - slopes.xy * slopes.xy, vec2(0.0))")},
       steep_and_sharp},
      {{"glsl-half-vectors-at-the-horizon", file,
        "a half vector at the horizon has an infinite slope, so the distance between slopes is infinity minus infinity",
        "half vectors with z up to 1e-4 reflect nothing", kNothingWrong, "deviation of light that must be 0",
        "the result must be exact"},
       {glsl_edit("if (h.z <= 1e-4) return 0.0;", "")},
       half_vectors_at_the_horizon},
  };
}

}  // namespace

std::vector<GlslCase> glsl_planar_cases() {
  std::vector<GlslCase> cases = gaussian_cases();
  for (GlslCase& c : moment_cases()) cases.push_back(std::move(c));
  return cases;
}

}  // namespace multum::gl
