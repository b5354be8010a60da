// SPDX-License-Identifier: Apache-2.0
// Tests the shading of filtered lobes (kernels/movmf_shade.cl, device/vmf_shading.clh) with parameters that are 0, 1 or
// extreme (docs/contributing/ALGORITHMS.md, "Shading a filtered lobe"). Lobes point along +z, so (a r, a) is exact in
// float, and only the formula causes an error.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/bakes/accuracy/highlight.h"
#include "host/lab/reference/shading.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/shade_launch.h"

namespace multum {
namespace {

std::vector<double> launch(Device& device, const glm::vec4& lobe, const MultumHighlight& shaded,
                           const std::vector<glm::vec4>& directions, bool planar, bool lambert) {
  const int count = static_cast<int>(directions.size());
  const DeviceBuffer lobes = device.wrap_buffer(&lobe, sizeof(lobe), "lobe");
  const DeviceBuffer vectors =
      device.wrap_buffer(directions.data(), directions.size() * sizeof(glm::vec4), "directions");
  const DeviceBuffer highlight = device.wrap_buffer(&shaded, sizeof(shaded), "highlight");
  std::vector<float> values(directions.size(), NAN);
  DeviceBuffer out = device.make_buffer(values.size() * sizeof(float), "values");
  device.write(out, values.data(), out.byte_count());
  device.kernel("movmf_shade", "movmf_shade", {1, 1, false, planar})
      .launch({1}, lobes, vectors, vectors, highlight, out, 1, lambert ? 0 : count, lambert ? count : 0,
              lambert ? 0 : 1);
  device.read(out, values.data(), out.byte_count());
  return {values.begin(), values.end()};
}

}  // namespace

std::vector<double> shade_lobe(Device& device, const glm::vec4& lobe, float s, const std::vector<glm::vec4>& directions,
                               bool planar) {
  return launch(device, lobe, shaded_highlight(static_cast<double>(s)), directions, planar, s == 0.0f);
}

std::vector<double> shade_lobe(Device& device, const glm::vec4& lobe, const MultumHighlight& highlight,
                               const std::vector<glm::vec4>& directions) {
  return launch(device, lobe, highlight, directions, false, false);
}

SourceEdit shade_edit(const std::string& text, const std::string& replacement) {
  return {"movmf_shade", text, replacement};
}

double angle_seen(const glm::dvec3& mu, const glm::vec4& w) {
  return 2.0 * std::asin(std::min(1.0, 0.5 * glm::length(mu - glm::dvec3(w))));
}

namespace {

const glm::dvec3 kUp(0.0, 0.0, 1.0);

glm::vec4 direction(double theta) {
  return {static_cast<float>(std::sin(theta)), 0.0f, static_cast<float>(std::cos(theta)), 0.0f};
}

std::vector<glm::vec4> directions_to(double theta_max, int count) {
  std::vector<glm::vec4> directions;
  for (int i = 0; i < count; ++i) directions.push_back(direction(theta_max * (i + 0.5) / count));
  return directions;
}

glm::vec4 lobe_of(double amplitude, double spread) {
  return {0.0f, 0.0f, static_cast<float>(amplitude * (1.0 - spread)), static_cast<float>(amplitude)};
}

constexpr double kSpreads[] = {0.0, 0x1p-23, 0x1p-20, 0x1p-14, 0x1p-7, 0.125, 0.5, 0.875, 1.0 - 0x1p-20, 1.0};

// Compares the shading with the formula in double precision, relative to the peak of the lobe.
void add_blinn_phong(Device& device, const glm::vec4& lobe, double spread, double s,
                     const std::vector<glm::vec4>& directions, WorstError& worst) {
  const double amplitude = static_cast<double>(lobe.w), peak = reference::product_blinn_phong(s, spread, 0.0);
  const std::vector<double> values = shade_lobe(device, lobe, static_cast<float>(s), directions);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double theta = angle_seen(kUp, directions[i]);
    worst.add(values[i] / amplitude, reference::product_blinn_phong(s, spread, theta), peak,
              fmt::format("s {}, 1 - |r| = {:.3g}, {:.4g} degrees", s, spread, theta * 180.0 / std::numbers::pi));
  }
}

void exponents_to_1e5(Device& device, WorstError& worst) {
  for (const double s : {1.0, 5.0, 20.0, 100.0, 2000.0, 1e5})
    for (const double spread : kSpreads)
      add_blinn_phong(device, lobe_of(1.0, spread), spread, s,
                      directions_to(std::min(0.5 * std::numbers::pi, 4.0 * std::sqrt(spread + 1.0 / (s + 2.0))), 40),
                      worst);
}

// Omits 90 degrees, because a power with exponent 0 is discontinuous there.
void horizon_and_below(Device& device, WorstError& worst) {
  const std::vector<glm::vec4> directions = {direction(0.5 * std::numbers::pi - 1e-4),
                                             direction(0.5 * std::numbers::pi + 1e-4),
                                             direction(2.0),
                                             direction(3.0),
                                             {0.0f, -0.0f, -1.0f, 0.0f}};
  for (const double s : {1.0, 5.0, 100.0, 1e5})
    for (const double spread : {0.0, 0.5, 0.625, 0.875})
      add_blinn_phong(device, lobe_of(1.0, spread), spread, s, directions, worst);
}

void longer_than_one(Device& device, WorstError& worst) {
  for (const double excess : {0x1p-23, 0x1p-17, 1e-3})
    for (const double s : {5.0, 100.0, 1e5})
      add_blinn_phong(device, lobe_of(1.0, -excess), 0.0, s, directions_to(3.0 / std::sqrt(s), 20), worst);
}

void no_mean_direction(Device& device, WorstError& worst) {
  const std::vector<glm::vec4> directions = directions_to(std::numbers::pi, 16);
  for (const glm::vec4 lobe : {glm::vec4(0.0f, 0.0f, 0.0f, 1.0f), glm::vec4(-0.0f, 0.0f, 1e-40f, 1.0f)}) {
    for (const double s : {1.0, 100.0, 1e5}) add_blinn_phong(device, lobe, 1.0, s, directions, worst);
    for (const double value : shade_lobe(device, lobe, 0.0f, directions)) worst.add(value, 0.25, 0.25, "Lambert");
  }
}

// Tests the small amplitudes that remain after filtering. Errors are relative to the amplitude, and the result must be
// 0 if the amplitude is below 1e-6.
void vanishing_amplitude(Device& device, WorstError& worst) {
  for (const double amplitude : {0.5, 1e-3, 1.0 / 32767.0, 2e-6, 1.01e-6, 1e-6, 1e-8, 1e-30, 1e-40, 0.0}) {
    const glm::vec4 lobe = lobe_of(amplitude, 0.125);
    if (static_cast<double>(lobe.w) > static_cast<double>(1e-6f)) {
      add_blinn_phong(device, lobe, 1.0 - static_cast<double>(lobe.z) / static_cast<double>(lobe.w), 50.0,
                      directions_to(1.0, 16), worst);
      continue;
    }
    for (const float s : {0.0f, 1.0f, 1e5f})
      for (const double value : shade_lobe(device, lobe, s, directions_to(1.0, 4)))
        worst.add(value == 0.0 ? 0.0 : 1.0 + 0.0 * value, fmt::format("amplitude {}", amplitude));
  }
}

// Tests GGX as a sum of vMFs with positive and negative weights, compared with the same sum in double precision.
void terms_of_either_sign(Device& device, WorstError& worst) {
  Highlight ggx;
  ggx.brdf.kind = BrdfKind::kGgx;
  for (const float roughness : {0.05f, 0.2f, 0.5f, 0.8f, 1.0f}) {
    ggx.brdf.roughness = roughness;
    const MultumHighlight shaded = shaded_highlight(ggx.brdf);
    for (const double spread : kSpreads) {
      const auto sum_of = [&](double theta, const auto& weight) {
        double sum = 0.0;
        for (std::size_t i = 0; i < static_cast<std::size_t>(shaded.term_count); ++i)
          sum += weight(static_cast<double>(shaded.weights[i])) *
                 reference::vmf_density(
                     reference::vmf_kappa(spread + (1.0 - spread) * static_cast<double>(shaded.spreads[i])), theta);
        return sum;
      };
      const double peaks = sum_of(0.0, [](double w) { return std::abs(w); });
      const std::vector<glm::vec4> directions = directions_to(std::numbers::pi, 60);
      const std::vector<double> values = shade_lobe(device, lobe_of(1.0, spread), shaded, directions);
      for (std::size_t i = 0; i < values.size(); ++i)
        worst.add(values[i], std::max(sum_of(angle_seen(kUp, directions[i]), [](double w) { return w; }), 0.0), peaks,
                  fmt::format("roughness {}, 1 - |r| = {:.3g}, direction {}", roughness, spread, i));
    }
  }
}

void lambert_of_every_spread(Device& device, WorstError& worst) {
  const std::vector<glm::vec4> directions = directions_to(std::numbers::pi, 48);
  const auto add = [&](double spread, const std::function<double(double)>& exact) {
    const std::vector<double> values = shade_lobe(device, lobe_of(1.0, spread), 0.0f, directions);
    for (std::size_t i = 0; i < values.size(); ++i)
      worst.add(values[i], exact(angle_seen(kUp, directions[i])), 1.0,
                fmt::format("1 - |r| = {:.3g}, direction {}", spread, i));
  };
  add(0.0, [](double theta) { return std::max(std::cos(theta), 0.0); });
  add(1.0, [](double) { return 0.25; });
  for (const double kappa : {0.1, 1.0, 3.0, 10.0, 50.0, 500.0})
    add(reference::vmf_spread(kappa), [kappa](double theta) { return reference::convolved_lambert(kappa, theta); });
}

std::vector<NumericalCase> lobe_cases() {
  const char* kReason = "the error of kappa (2.3e-4) changes both the peak and the exponent of the highlight";
  return {
      {{"exponents-to-1e5", "movmf_shade",
        "1 - mu . h has a rounding error of 6e-8, which the highlight exponent s = 1e5 multiplies",
        "1 - mu . h is computed as |mu - h|^2 / 2, and 1 - A as a sum of small terms, where A is the mean cosine", 6e-4,
        "of the peak", kReason},
       exponents_to_1e5,
       {shade_edit("return 0.5f * fma(dx, dx, fma(dy, dy, dz * dz));",
                   "return 1.0f - fma(dx + w.x, w.x, fma(dy + w.y, w.y, (dz + w.z) * w.z));")}},
      {{"the-horizon-and-below", "movmf_shade",
        "the computed power of a negative cosine is positive, so surfaces that face away from the light are lit",
        "the result is 0 if the cosine t is 0 or negative", 6e-4, "of the peak", kReason},
       horizon_and_below,
       {shade_edit("return e < 1.0f ?", "return true ?")}},
      {{"longer-than-its-amplitude", "movmf_shade",
        "rounding makes the vector a r longer than the amplitude a, so the spread and kappa are negative",
        "the spread is clamped to the range 0 to 1", 6e-4, "of the peak", kReason},
       longer_than_one,
       {shade_edit("clamp((lobe.w - length) / max(lobe.w, AMPLITUDE_SHADED_MIN), 0.0f, 1.0f)",
                   "((lobe.w - length) / max(lobe.w, AMPLITUDE_SHADED_MIN))")}},
      {{"no-direction", "movmf_shade", "normalising a mean r of length 0 divides by zero",
        "the kernel uses an arbitrary direction, because the result does not depend on it", 6e-4, "of the peak",
        kReason},
       no_mean_direction,
       {shade_edit("const real_v inverse = length > 1e-12f ? 1.0f / length : (real_v)(0.0f);",
                   "const real_v inverse = 1.0f / length;")}},
  };
}

}  // namespace

std::vector<NumericalCase> shading_cases() {
  std::vector<NumericalCase> cases = lobe_cases();
  cases.push_back(
      {{"amplitude-to-0", "movmf_shade",
        "the vector of an empty lobe is divided by the lobe's amplitude, which is 0, or rounding errors determine the "
        "direction from which the lobe reflects light",
        "the kernel ignores lobes with amplitudes up to 1e-6, a thirtieth of the smallest stored amplitude", 6e-4,
        "of the peak times the amplitude (light that must be 0 counts as an error of 1)",
        "the error of kappa (2.3e-4) changes both the peak and the exponent of the highlight"},
       vanishing_amplitude,
       {shade_edit("shape.amplitude = lobe.w <= AMPLITUDE_SHADED_MIN ? (real_v)(0.0f) : lobe.w;",
                   "shape.amplitude = lobe.w;"),
        shade_edit("lobe.w <= AMPLITUDE_SHADED_MIN ? (real_v)(0.0f) : ", "")}});
  cases.push_back(
      {{"terms-of-either-sign", "movmf_shade",
        "a sum of vMFs with positive and negative weights can be negative, and negative light darkens its surroundings",
        "the sum over the terms of a lobe is at least 0", 6e-4, "of the sum of the terms' peaks",
        "the kappa of every term is computed with an error of 2.3e-4"},
       terms_of_either_sign,
       {shade_edit("lobe.w * max(sum, 0.0f);", "lobe.w * sum;")}});
  cases.push_back(
      {{"lambert-of-every-spread", "movmf_shade",
        "the paper's approximation max(mu . l, 0) ignores the spread of the lobe",
        "the formula uses the mean of a folded normal distribution, which is exact for single directions and for lobes "
        "without a direction",
        2.5e-3, "absolute error", "the model of the mean cosine has an error of 0.22 % (tools/lab/fit_shading.py)"},
       lambert_of_every_spread,
       {shade_edit("return 0.5f * (m + sqrt(fma(v, exp2_v(-MULTUM_LOG2E * g), m * m)));", "return max(t, 0.0f);")}});
  return cases;
}

}  // namespace multum
