// SPDX-License-Identifier: Apache-2.0
// Defines the numerical cases of movmf_shading.glsl and of Blinn-Phong highlights of lobes.

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

// Holds a lobe along +z (so that (a r, a) is exact in single precision), a direction in the plane y = 0, and a
// parameter.
struct Point {
  double amplitude, spread, theta, parameter;
};

glm::vec4 lobe_of(const Point& p) {
  return {0.0f, 0.0f, static_cast<float>(p.amplitude * (1.0 - p.spread)), static_cast<float>(p.amplitude)};
}
glm::vec4 direction_of(const Point& p) {
  return {static_cast<float>(std::sin(p.theta)), 0.0f, static_cast<float>(std::cos(p.theta)),
          static_cast<float>(p.parameter)};
}

// Returns the angle between the shader's vectors of floats, whose lengths are not exactly 1.
double angle_seen(const Point& p) {
  const glm::vec4 w = direction_of(p);
  const double x = static_cast<double>(w.x), z = static_cast<double>(w.z) - 1.0;
  return 2.0 * std::asin(std::min(1.0, 0.5 * std::sqrt(x * x + z * z)));
}

std::string text_of(const Point& p) {
  return fmt::format("a {:.3g}, 1 - |r| = {:.3g}, {:.4g} degrees, parameter {:.3g}", p.amplitude, p.spread,
                     p.theta * 180.0 / std::numbers::pi, p.parameter);
}

std::vector<double> evaluated(const GlFunctions& gl, const Edits& edits, const std::string& expression,
                              const std::vector<Point>& points) {
  GlslInputs inputs;
  for (const Point& p : points) inputs.emplace_back(lobe_of(p), direction_of(p));
  std::vector<double> values;
  for (const glm::vec4& value : evaluate_glsl(gl, edits, "vec4(" + expression + ")", inputs, {}))
    values.push_back(static_cast<double>(value.x));
  return values;
}

// Adds the relative errors of a function of the single number `b.w` for all `inputs`.
void add_function(const GlFunctions& gl, const Edits& edits, const std::string& expression,
                  const std::vector<double>& inputs, const std::function<double(double)>& exact, WorstError& worst) {
  std::vector<Point> points;
  for (const double x : inputs) points.push_back({1.0, 0.0, 0.0, static_cast<double>(static_cast<float>(x))});
  const std::vector<double> values = evaluated(gl, edits, expression, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double expected = exact(points[i].parameter);
    worst.add(values[i], expected, std::abs(expected), fmt::format("at {:.9g}", points[i].parameter));
  }
}

std::vector<double> decades(double low, double high, double factor) {
  std::vector<double> values;
  for (double x = low; x < high; x *= factor) values.push_back(x);
  return values;
}

constexpr char kBlinnPhongOfLobe[] = "multum_movmf_blinn_phong(a, b.xyz, b.w)";

void add_blinn_phong(const GlFunctions& gl, const Edits& edits, const std::vector<Point>& points, WorstError& worst) {
  const std::vector<double> values = evaluated(gl, edits, kBlinnPhongOfLobe, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    const double spread = std::clamp(p.spread, 0.0, 1.0);
    worst.add(values[i] / p.amplitude, reference::product_blinn_phong(p.parameter, spread, angle_seen(p)),
              reference::product_blinn_phong(p.parameter, spread, 0.0), text_of(p));
  }
}

void kappa(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<double> inputs = decades(1e-6, 0.5, 1.0117);
  for (double mean = 0.5; mean > 3e-7; mean *= 0.97) inputs.push_back(1.0 - mean);
  add_function(
      gl, edits, "multum_vmf_kappa(b.w)", inputs, [](double q) { return reference::vmf_kappa(q); }, worst);
}

void vmf_spread(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  add_function(
      gl, edits, "multum_vmf_spread(b.w)", decades(1e-6, 1e6, 1.0231),
      [](double k) { return reference::vmf_spread(k); }, worst);
}

void normaliser(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<double> inputs = decades(1e-6, 1e6, 1.0231);
  for (const double kappa_of_zero : {0.0, 1e-30, 1e-40}) inputs.push_back(kappa_of_zero);
  add_function(
      gl, edits, "multum_vmf_density(b.w, 0.0)", inputs, [](double k) { return reference::vmf_density(k, 0.0); },
      worst);
}

void log_one_minus(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  add_function(
      gl, edits, "multum_log_one_minus(b.w)", decades(1e-9, 0.999, 1.0171), [](double e) { return std::log1p(-e); },
      worst);
}

void exponents_to_1e5(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<Point> points;
  for (const double s : {1.0, 5.0, 20.0, 100.0, 2000.0, 1e5})
    for (const double spread : {0.0, 0x1p-23, 0x1p-20, 0x1p-14, 0x1p-7, 0.125, 0.5, 0.875, 1.0})
      for (int i = 0; i < 40; ++i)
        points.push_back({1.0, spread,
                          std::min(0.5 * std::numbers::pi, 4.0 * std::sqrt(spread + 1.0 / (s + 2.0))) * (i + 0.5) / 40,
                          s});
  add_blinn_phong(gl, edits, points, worst);
}

void horizon_and_below(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<Point> points;
  for (const double s : {1.0, 5.0, 100.0, 1e5})
    for (const double spread : {0.0, 0.5, 0.625, 0.875})
      for (const double theta :
           {0.5 * std::numbers::pi - 1e-4, 0.5 * std::numbers::pi + 1e-4, 2.0, 3.0, std::numbers::pi})
        points.push_back({1.0, spread, theta, s});
  add_blinn_phong(gl, edits, points, worst);
}

void longer_than_amplitude(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<Point> points;
  for (const double excess : {0x1p-23, 0x1p-17, 1e-3})
    for (const double s : {5.0, 100.0, 1e5})
      for (int i = 0; i < 20; ++i) points.push_back({1.0, -excess, 3.0 / std::sqrt(s) * (i + 0.5) / 20, s});
  add_blinn_phong(gl, edits, points, worst);
}

void no_direction(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<Point> points;
  for (const double s : {1.0, 100.0, 1e5})
    for (int i = 0; i < 16; ++i) points.push_back({1.0, 1.0, std::numbers::pi * (i + 0.5) / 16, s});
  add_blinn_phong(gl, edits, points, worst);
  for (const double value : evaluated(gl, edits, "multum_movmf_lambert(a, b.xyz)", points))
    worst.add(value, 0.25, 0.25, "Lambert");
}

void amplitude_to_0(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<Point> lit, dark;
  for (const double amplitude : {0.5, 1e-3, 1.0 / 32767.0, 2e-6}) {
    const double stored = static_cast<double>(static_cast<float>(amplitude));
    const double mean = static_cast<double>(static_cast<float>(stored * 0.875));
    for (const double theta : {0.0, 0.2, 0.9}) lit.push_back({stored, 1.0 - mean / stored, theta, 50.0});
  }
  add_blinn_phong(gl, edits, lit, worst);
  for (const double amplitude : {1e-6, 1e-8, 1e-30, 1e-40, 0.0})
    for (const double s : {1.0, 1e5}) dark.push_back({amplitude, 0.125, 0.1, s});
  for (const char* expression : {kBlinnPhongOfLobe, "multum_movmf_blinn_phong_paper(a, b.xyz, b.w)",
                                 "multum_movmf_lambert(a, b.xyz)", "multum_movmf_torrance_sparrow(a, b.xyz, 0.3)"}) {
    const std::vector<double> values = evaluated(gl, edits, expression, dark);
    for (std::size_t i = 0; i < values.size(); ++i)
      worst.add(values[i] == 0.0 ? 0.0 : 1.0 + 0.0 * values[i], fmt::format("{}: {}", expression, text_of(dark[i])));
  }
}

// Tests the paper's rule, which is kept for comparison. The shader must match the formula of the rule, but can differ
// from the reference.
void papers_rule(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<Point> points;
  for (const double s : {1.0, 100.0, 1e5})
    for (const double spread : {0.0, 0x1p-20, 0x1p-7, 0.5, 0.875})
      for (int i = 0; i < 20; ++i) points.push_back({1.0, spread, 3.0 / std::sqrt(s) * (i + 0.5) / 20, s});
  const std::vector<double> values = evaluated(gl, edits, "multum_movmf_blinn_phong_paper(a, b.xyz, b.w)", points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    const double lobe_kappa = p.spread > 0.0 ? reference::vmf_kappa(p.spread) : 1e12;
    const double power = lobe_kappa * p.parameter / (lobe_kappa + p.parameter);
    worst.add(values[i], reference::blinn_phong(power, angle_seen(p)), reference::blinn_phong(power, 0.0), text_of(p));
  }
}

// Tests `sigma = 1 / sqrt(2 kappa_f)`, from mirrors to shapes too broad for a facet distribution.
void torrance_sparrow(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<Point> points;
  for (const double sigma : {1e-3, 0.01, 0.1, 0.5, 1.0})
    for (const double spread : {0.0, 0x1p-20, 0x1p-7, 0.5, 1.0})
      for (int i = 0; i < 20; ++i)
        points.push_back({1.0, spread, std::min(std::numbers::pi, 3.0 * (sigma + std::sqrt(spread))) * (i + 0.5) / 20,
                          static_cast<double>(static_cast<float>(sigma))});
  const std::vector<double> values = evaluated(gl, edits, "multum_movmf_torrance_sparrow(a, b.xyz, b.w)", points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    const double of_brdf = reference::vmf_spread(0.5 / (p.parameter * p.parameter));
    const double shape = reference::vmf_kappa(p.spread + (1.0 - p.spread) * of_brdf);
    worst.add(values[i], reference::vmf_density(shape, angle_seen(p)), reference::vmf_density(shape, 0.0), text_of(p));
  }
}

// Tests lobes from single directions to lobes without a direction, and facets from mirrors to facets of the whole
// sphere. Half vectors are parallel, perpendicular and opposite to the lobe. The sum of two opposite vMFs of equal
// kappa has no direction.
void highlight_cosines(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const glm::dvec3 l = glm::normalize(glm::dvec3(0.3, -0.5, 0.8)), up(0.0, 0.0, 1.0);
  GlslComparison c{
      fmt::format("vec4(multum_movmf_highlight_cosine(a, b.xyz, vec3({}, {}, {}), b.w))", l.x, l.y, l.z), {}, {}};
  for (const float r : {0.0f, 1e-6f, 0.125f, 0.5f, 0.9375f, 0.9999f})
    for (const double facet_kappa : {0.5, 10.0, 1e3, 1e5})
      for (const glm::dvec3& h : {up, tilted(90.0), tilted(45.0), tilted(150.0), l})
        c.inputs.push_back({{0.0f, 0.0f, 0.25f * r, 0.25f}, with(h, facet_kappa)});
  c.exact = [=](const glm::dvec4& a, const glm::dvec4& b) {
    const double kappa = a.z > 0.0 ? reference::vmf_kappa(1.0 - a.z / a.w) : 0.0;
    return glm::dvec4(highlight_cosine(b.w * glm::dvec3(b) + kappa * up, l));
  };
  compare_glsl(gl, edits, c, worst);
  // The half vector is exactly opposite to the lobe, and the facets have the kappa that the shader computes for the
  // lobe.
  c.expression =
      "vec4(multum_movmf_highlight_cosine(a, -a.xyz / a.z, vec3(0.0, 0.0, 1.0), "
      "multum_vmf_kappa(multum_movmf_spread(a))))";
  c.inputs = {{{0.0f, 0.0f, 0.5f, 1.0f}, {}}, {{0.0f, 0.0f, 0.9375f, 1.0f}, {}}};
  c.exact = [](const glm::dvec4&, const glm::dvec4&) { return glm::dvec4(0.25); };
  compare_glsl(gl, edits, c, worst);
}

void lambert(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  const auto add = [&](double spread, const std::function<double(double)>& exact) {
    std::vector<Point> points;
    for (int i = 0; i < 48; ++i) points.push_back({1.0, spread, std::numbers::pi * (i + 0.5) / 48, 0.0});
    const std::vector<double> values = evaluated(gl, edits, "multum_movmf_lambert(a, b.xyz)", points);
    for (std::size_t i = 0; i < points.size(); ++i)
      worst.add(values[i], exact(angle_seen(points[i])), 1.0, text_of(points[i]));
  };
  add(0.0, [](double theta) { return std::max(std::cos(theta), 0.0); });
  add(1.0, [](double) { return 0.25; });
  for (const double kappa_of_lobe : {0.1, 1.0, 3.0, 10.0, 50.0, 500.0})
    add(reference::vmf_spread(kappa_of_lobe),
        [=](double theta) { return reference::convolved_lambert(kappa_of_lobe, theta); });
}

// Tests that the share is between 0 and 1 at every level of detail.
void normal_map_share(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  std::vector<Point> points;
  for (const double lod : {-1e30, -40.0, -1.0, -0.25, -0.0, 0.0, 1e-40, 3.0, 1e30})
    points.push_back({1.0, 0.0, 0.0, lod});
  const std::vector<double> values = evaluated(gl, edits, "multum_normal_map_share(b.w)", points);
  for (std::size_t i = 0; i < points.size(); ++i)
    worst.add(values[i], std::clamp(-points[i].parameter, 0.0, 1.0), 1.0, text_of(points[i]));
}

// Tests mean normals from length 0 to longer than their amplitude, and pixels from much smaller to much larger than
// texels.
void magnified(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"multum_movmf_magnified(a, b.x)", {}, {}};
  for (const float amplitude : {0.0f, 0.5f, 1.0f})
    for (const float length : {0.0f, 1e-9f, 1e-3f, 0.9f, 1.0f, 1.001f})
      for (const float lod : {-1e30f, -40.0f, -1.0f, 0.0f, 0.5f, 9.0f, 1e30f})
        c.inputs.push_back({glm::vec4(amplitude * length * glm::vec3(tilted(40.0)), amplitude), glm::vec4(lod)});
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double length = glm::length(glm::dvec3(a)), seen = std::min(0.5 * std::exp2(2.0 * b.x), 1.0);
    const double scale = length > 1e-6 ? (a.w - (a.w - length) * seen) / length : 1.0;
    return glm::dvec4(glm::dvec3(a) * scale, a.w);
  };
  compare_glsl(gl, edits, c, worst);
}

// Tests lobes that were shortened for the width of a BRDF, with every mean cosine. The lengths of these lobes range
// from 0 to more than their amplitude.
void roughness_taken_out(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"multum_movmf_without_roughness(a, b.x)", {}, {}};
  for (const float amplitude : {0.0f, 1e-30f, 1e-6f, 0.5f, 1.0f})
    for (const float length : {0.0f, 1e-6f, 0.5f, 0.9f, 1.0f, 1.001f})
      for (const float mean_cosine : {1e-3f, 0.5f, 0.9f, 1.0f})
        c.inputs.push_back(
            {glm::vec4(amplitude * length * glm::vec3(tilted(40.0)), amplitude), glm::vec4(mean_cosine)});
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double length = glm::length(glm::dvec3(a)), scale = std::min(1.0 / b.x, a.w / std::max(length, 1e-12));
    return glm::dvec4(glm::dvec3(a) * scale, a.w);
  };
  compare_glsl(gl, edits, c, worst);
}

std::vector<GlslCase> function_cases() {
  const std::string file = "movmf_shading.glsl";
  return {
      {{"glsl-vmf-spread-12-decades", file,
        "near kappa = 0, the difference 1/kappa - 2/(exp(2 kappa) - 1) loses its digits by cancellation",
        "below kappa = 0.1, two terms of the series are used", 2e-5, "relative error",
        "at kappa = 0.1, two terms near 10 have a difference near 1, so rounding errors and errors of the GL's exp "
        "grow ten times"},
       {glsl_edit("if (kappa < 0.1) return", "if (false) return")},
       vmf_spread,
       {"multum_vmf_spread"}},
      {{"glsl-kappa-12-decades", file,
        "Banerjee's factor 3 - A^2, where A is the mean cosine, has an error of several per cent",
        "a polynomial refines the factor, and 1 - A^2 is computed as q (2 - q) with q = 1 - A, which avoids "
        "cancellation",
        2.4e-4, "relative error", "the polynomial approximates kappa with an error of 2.3e-4"},
       {glsl_edit("(3.0 - x + x * (1.0 - x) * p)", "(3.0 - x)")},
       kappa,
       {"multum_vmf_kappa"}},
      {{"glsl-vmf-normaliser-12-decades", file, "kappa / (1 - exp(-2 kappa)) divides 0 by 0 at kappa = 0",
        "below kappa = 1e-3, the approximation (1 + kappa) / 2 is used", 1e-4, "relative error",
        "at kappa = 1e-3, the divisor 1 - exp(-2 kappa) is only 2e-3, so the rounding error of exp, 6e-8, grows to "
        "3e-5"},
       {glsl_edit("kappa > 1e-3 ?", "true ?")},
       normaliser,
       {"multum_vmf_density"}},
      {{"glsl-log-of-one-minus-e", "blinn_phong.glsl",
        "the cosine t = 1 - e has a rounding error of 6e-8, which the highlight exponent s = 1e5 multiplies",
        "below e = 0.1, log(1 - e) is computed by the series of -2 atanh(e / (2 - e))", 1e-6, "relative error",
        "the omitted terms of the series add only 3e-9, and the GL's log adds a small error"},
       {glsl_edit("if (e > 0.1) return", "if (true) return")},
       log_one_minus,
       {"multum_log_one_minus"}},
      {{"glsl-normal-map-share", file, "at an extreme level of detail, the normal map gets a share of -1e30 or 1e30",
        "the share is clamped to the range 0 to 1", 1e-6, "absolute error", "the shader only copies the share"},
       {glsl_edit("clamp(-lod, 0.0, 1.0)", "(-lod)")},
       normal_map_share,
       {"multum_normal_map_share"}},
      {{"glsl-magnified-normal-map", file,
        "normals can cancel, so normalising their sum gives NaN, and the variance can exceed the length that filtering "
        "removed",
        "the shader does not normalise means shorter than 1e-6, and limits the variance to the length that filtering "
        "removed",
        1e-6, "absolute error", "only a length and two quotients are rounded"},
       {glsl_edit("if (size <= MULTUM_AMPLITUDE_MIN) return lobe;", ""), glsl_edit("min(map_lod, 0.5)", "map_lod")},
       magnified,
       {"multum_movmf_magnified"}},
      {{"glsl-roughness-taken-out", file,
        "a lobe vector longer than its amplitude reflects too much light, and normalising a vector of length 0 divides "
        "0 by 0",
        "the length is at most the amplitude, and the divisor is at least 1e-12", 1e-6, "absolute error",
        "only a length and two quotients are rounded"},
       {glsl_edit("lobe.w / max(length(lobe.xyz), 1e-12)", "1.0 / mean_cosine")},
       roughness_taken_out,
       {"multum_movmf_without_roughness"}},
  };
}

std::vector<GlslCase> lobe_cases() {
  const std::string file = "movmf_shading.glsl",
                    reason = "the error of kappa (2.3e-4) changes both the peak and the exponent of the highlight";
  return {
      {{"glsl-exponents-to-1e5", "movmf_shading.glsl, blinn_phong.glsl",
        "1 - mu . h has a rounding error of 6e-8, which the highlight exponent s = 1e5 multiplies",
        "1 - mu . h is computed as |mu - h|^2 / 2, and 1 - A as a sum of small terms, where A is the mean cosine", 6e-4,
        "of the peak", reason},
       {glsl_edit("return 0.5 * dot(difference, difference);", "return 1.0 - dot(mu, w);")},
       exponents_to_1e5,
       {"multum_one_minus_cosine", "multum_movmf_mean_direction", "multum_movmf_blinn_phong"}},
      {{"glsl-the-horizon-and-below", "blinn_phong.glsl",
        "the computed power of a negative cosine is positive, so surfaces that face away from the light are lit",
        "the result is 0 if the cosine t is 0 or negative", 6e-4, "of the peak", reason},
       {glsl_edit("return e < 1.0 ?", "return true ?")},
       horizon_and_below,
       {"multum_blinn_phong"}},
      {{"glsl-longer-than-its-amplitude", file,
        "rounding makes the vector a r longer than the amplitude a, so the spread and kappa are negative",
        "the spread is clamped to the range 0 to 1", 6e-4, "of the peak", reason},
       {glsl_unclamped_spread()},
       longer_than_amplitude,
       {"multum_movmf_spread"}},
      {{"glsl-no-direction", file, "normalising a mean r of length 0 divides by zero",
        "the shader uses a fixed direction, because the result does not depend on it", 6e-4, "of the peak", reason},
       {glsl_edit("size > 1e-12 ? lobe.xyz / size : vec3(0.0, 0.0, 1.0)", "lobe.xyz / size")},
       no_direction},
      {{"glsl-amplitude-to-0", file,
        "the vector of an empty lobe is divided by the lobe's amplitude, which is 0, or the empty lobe reflects light",
        "the shader ignores lobes with amplitudes up to 1e-6, a thirtieth of the smallest stored amplitude", 6e-4,
        "of the peak times the amplitude (light that must be 0 counts as an error of 1)", reason},
       {glsl_edit("if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;", "")},
       amplitude_to_0},
      {{"glsl-the-papers-rule", "blinn_phong.glsl",
        "a single direction has an infinite kappa, and dividing infinity by infinity gives NaN",
        "the denominator of kappa is at least 1e-12", 6e-4, "of the peak", reason},
       {glsl_edit("max(q * (2.0 - q), 1e-12)", "(q * (2.0 - q))")},
       papers_rule,
       {"multum_movmf_blinn_phong_paper"}},
      {{"glsl-torrance-sparrow-of-every-sigma", "torrance_sparrow.glsl",
        "for rough facets, the approximation 1 - 1/kappa of the mean cosine is inaccurate",
        "both terms of the mean cosine are used, and the argument of exp is at most 80, where the second term vanishes",
        6e-4, "of the peak", reason},
       {glsl_edit("1.0 / kappa - 2.0 / (exp(min(2.0 * kappa, 80.0)) - 1.0)", "1.0 / kappa")},
       torrance_sparrow,
       {"multum_movmf_torrance_sparrow"}},
      {{"glsl-lambert-of-every-spread", file, "the paper's approximation max(mu . l, 0) ignores the spread of the lobe",
        "the formula uses the mean of a folded normal distribution, which is exact for single directions and for lobes "
        "without a direction",
        2.5e-3, "absolute error", "the model of the mean cosine has an error of 0.22 % (tools/lab/fit_shading.py)"},
       {glsl_edit("return 0.5 * (m + sqrt(m * m + v * exp(-g)));", "return max(t, 0.0);")},
       lambert,
       {"multum_movmf_lambert", "multum_vmf_mean_cosine"}},
      {{"glsl-highlight-cosines-of-every-width", file,
        "the vectors of the facets and of an opposite lobe of equal sharpness cancel, so their sum has no direction",
        "the divisor is at least 1e-6", 2.5e-3, "absolute error",
        "the model of the mean cosine has an error of 0.22 %"},
       {glsl_edit("max(size, 1e-6)", "size")},
       highlight_cosines,
       {"multum_movmf_highlight_cosine", "multum_movmf_reflecting_normals"}},
  };
}

}  // namespace

std::vector<GlslCase> glsl_lobe_cases() {
  std::vector<GlslCase> cases = function_cases();
  for (GlslCase& c : lobe_cases()) cases.push_back(std::move(c));
  return cases;
}

}  // namespace multum::gl
