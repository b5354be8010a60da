// SPDX-License-Identifier: Apache-2.0
// Tests the functions in kernels/device over their whole range and beyond. Also tests how the driver handles structs
// and NaN. The formulas are in docs/contributing/ALGORITHMS.md, "Von Mises-Fisher lobes".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "host/lab/reference/movmf_em.h"
#include "host/lab/reference/shading.h"
#include "host/lab/selftest/buffers.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/struct_layout.h"

namespace multum {
namespace {

// Lists the probes in the order of kernels/probe_numerics.cl.
enum class Probe : int { kExp2, kLog2, kKappa, kIsNan, kLogPeak, kOneMinusLog, kShadingKappa, kVmfPeak, kVmfSpread };

std::vector<double> probed(Device& device, const std::vector<float>& inputs, Probe function) {
  const DeviceBuffer in = device.wrap_buffer(inputs.data(), inputs.size() * sizeof(float), "inputs");
  const DeviceBuffer out = device.make_buffer(inputs.size() * sizeof(float), "values");
  device.kernel("probe_numerics", "probe_functions", {4, 1, false})
      .launch({inputs.size(), 16}, in, out, static_cast<int>(inputs.size()), static_cast<int>(function));
  std::vector<float> values(inputs.size());
  device.read(out, values.data(), values.size() * sizeof(float));
  return {values.begin(), values.end()};
}

// Returns numbers from `low` to `high`, each `factor` times the previous number.
std::vector<float> decades(double low, double high, double factor) {
  std::vector<float> values;
  for (double x = low; x < high; x *= factor) values.push_back(static_cast<float>(x));
  values.push_back(static_cast<float>(high));
  return values;
}

std::string at(const char* name, double value) { return fmt::format("{} {:.9g}", name, value); }

// Adds the relative errors of a probe, compared with `exact`.
void add_relative(Device& device, Probe function, const std::vector<float>& inputs, const char* name,
                  const std::function<double(double)>& exact, WorstError& worst) {
  const std::vector<double> values = probed(device, inputs, function);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const double expected = exact(static_cast<double>(inputs[i]));
    worst.add(values[i], expected, std::abs(expected), at(name, static_cast<double>(inputs[i])));
  }
}

void exp2_in_range(Device& device, WorstError& worst) {
  std::vector<float> inputs;
  for (float x = -126.0f; x <= 20.0f; x += 0.00713f) inputs.push_back(x);
  for (float x : {0.0f, -0.0f, 1e-40f, -1e-40f, 127.0f}) inputs.push_back(x);
  add_relative(
      device, Probe::kExp2, inputs, "x", [](double x) { return std::exp2(x); }, worst);
}

void exp2_below_range(Device& device, WorstError& worst) {
  const std::vector<float> inputs = {-126.5f, -127.0f, -150.0f, -200.0f, -1e6f, -1e30f, -3e38f, -HUGE_VALF};
  add_relative(
      device, Probe::kExp2, inputs, "x", [](double) { return 0x1p-126; }, worst);
}

void log2_of_normals(Device& device, WorstError& worst) {
  const std::vector<float> inputs = decades(1.2e-38, 3e38, 1.00731);
  const std::vector<double> values = probed(device, inputs, Probe::kLog2);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const double exact = std::log2(static_cast<double>(inputs[i]));
    worst.add(values[i], exact, 5e-7 + 6e-8 * std::abs(exact), at("x", static_cast<double>(inputs[i])));
  }
}

// Tests the spreads that belong to kappa from 1e-6 to 1e6. If the spread is below 0.5, kappa is roughly proportional to
// the inverse of the spread. Above 0.5, r is about kappa / 3. The r of the probe is 1 - spread, which is exact in float
// for small spreads.
void kappa_of_mean_length(Device& device, WorstError& worst) {
  std::vector<float> spreads = decades(1e-6, 0.5, 1.0117);
  for (double r = 0.5; r > 3e-7; r *= 0.97) spreads.push_back(static_cast<float>(1.0 - r));
  add_relative(
      device, Probe::kKappa, spreads, "spread",
      [](double spread) {
        // Below a spread of 0.05, A = 1 - 1/kappa has an error of at most 2e-16.
        return spread < 0.05 ? 1.0 / spread : reference::kappa_of_mean_length(1.0 - spread);
      },
      worst);
}

void log_peak(Device& device, WorstError& worst) {
  const std::vector<float> inputs = decades(0.05, 1e6, 1.0117);
  const std::vector<double> values = probed(device, inputs, Probe::kLogPeak);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const auto kappa = static_cast<double>(inputs[i]);
    worst.add(values[i], std::log2(kappa / -std::expm1(-2.0 * kappa)), 1.0, at("kappa", kappa));
  }
}

void shading_kappa(Device& device, WorstError& worst) {
  // The inputs are q = 1 - A for kappa from 1e6 down to 1e-6.
  std::vector<float> inputs = decades(1e-6, 0.5, 1.0117);
  for (double mean = 0.5; mean > 3e-7; mean *= 0.97) inputs.push_back(static_cast<float>(1.0 - mean));
  add_relative(
      device, Probe::kShadingKappa, inputs, "q",
      [](double q) { return q < 0.05 ? 1.0 / q : reference::kappa_of_mean_length(1.0 - q); }, worst);
}

// Tests a single direction with a BRDF of width 0, for which q is 0.
void shading_kappa_of_nothing(Device& device, WorstError& worst) {
  for (const double kappa : probed(device, {0.0f, -0.0f, 1e-40f}, Probe::kShadingKappa))
    worst.add(std::isfinite(kappa) && kappa > 0.0 ? 0.0 : std::numeric_limits<double>::quiet_NaN(), "q 0");
}

void vmf_peak(Device& device, WorstError& worst) {
  std::vector<float> inputs = decades(1e-6, 1e6, 1.0231);
  for (const float kappa : {0.0f, 1e-30f, 1e-40f}) inputs.push_back(kappa);
  add_relative(
      device, Probe::kVmfPeak, inputs, "kappa", [](double kappa) { return reference::vmf_density(kappa, 0.0); }, worst);
}

void vmf_spreads(Device& device, WorstError& worst) {
  add_relative(
      device, Probe::kVmfSpread, decades(1e-6, 1e6, 1.0231), "kappa",
      [](double kappa) { return reference::vmf_spread(kappa); }, worst);
}

// Tests lobes that range from single directions to lobes without a direction, and facets that range from mirrors to
// facets over the whole sphere. Half vectors are parallel, perpendicular and opposite to the lobe. The sum of two
// opposite vMFs of equal kappa has no direction.
void highlight_cosines(Device& device, WorstError& worst) {
  const glm::dvec3 mu = glm::normalize(glm::dvec3(0.3, -0.2, 0.9)), across = glm::normalize(glm::dvec3(0.9, 0.0, -0.3));
  std::vector<glm::vec4> lobes, half_vectors, lights;
  for (const double kappa : {0.0, 1e-3, 0.5, 10.0, 1e3, 2e4})
    for (const double facet_kappa : {0.5, 10.0, 1e3, 1e5})
      for (const glm::dvec3& h : {mu, across, glm::normalize(mu + across), -mu})
        for (const glm::dvec3& light : {mu, across, -across, glm::dvec3(0.0, 0.0, -1.0)}) {
          const double r = kappa > 0.0 ? 1.0 - reference::vmf_spread(kappa) : 0.0;
          lobes.emplace_back(glm::dvec4(0.25 * r * mu, 0.25));
          half_vectors.emplace_back(glm::dvec4(h, facet_kappa));
          lights.emplace_back(glm::dvec4(light, 0.0));
        }
  for (const float r : {0.5f, 0.9375f}) {  // the facets have the kappa that the device computes for the lobe
    const auto kappa = static_cast<float>(probed(device, {1.0f - r}, Probe::kShadingKappa)[0]);
    lobes.emplace_back(0.0f, 0.0f, r, 1.0f);
    half_vectors.emplace_back(0.0f, 0.0f, -1.0f, kappa);
    lights.emplace_back(0.0f, 0.0f, 1.0f, 0.0f);
  }
  const DeviceBuffer out = device.make_buffer(lobes.size() * sizeof(float), "values");
  device.kernel("probe_numerics", "probe_highlight_cosine", {4, 1, false})
      .launch({lobes.size(), 16}, uploaded(device, lobes, "lobes"), uploaded(device, half_vectors, "half vectors"),
              uploaded(device, lights, "lights"), out, static_cast<int>(lobes.size()));
  const std::vector<float> found = downloaded<float>(device, out);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double facet_kappa = static_cast<double>(half_vectors[i].w), a = static_cast<double>(lobes[i].w);
    const glm::dvec3 r = glm::dvec3(lobes[i]) / a, l(lights[i]);
    const double length = glm::length(r);
    const double kappa = length > 0.0 ? reference::vmf_kappa(std::max(1.0 - length, 1e-9)) : 0.0;
    const glm::dvec3 sum =
        facet_kappa * glm::dvec3(half_vectors[i]) + (length > 0.0 ? kappa / length * r : glm::dvec3(0.0));
    const double size = glm::length(sum);
    const std::string input = fmt::format("|r| {:.9g}, kappa of the facets {:.3g}, number {}", length, facet_kappa, i);
    // If the lobe and the facets cancel, only rounding determines the direction of their sum, so any mean cosine is
    // possible.
    if (size < 1e-2 * facet_kappa) {
      worst.add(found[i] >= 0.0f && found[i] <= 1.0f ? 0.0 : std::numeric_limits<double>::quiet_NaN(), input);
      continue;
    }
    const double theta = std::acos(std::clamp(glm::dot(sum, l) / size, -1.0, 1.0));
    const double exact = length < 1.0 ? reference::mean_cosine(size, theta) : std::max(std::cos(theta), 0.0);
    worst.add(static_cast<double>(found[i]), exact, 1.0, input);
  }
}

void one_minus_log(Device& device, WorstError& worst) {
  add_relative(
      device, Probe::kOneMinusLog, decades(1e-9, 0.999, 1.0171), "e",
      [](double e) { return std::log1p(-e) * std::numbers::log2e; }, worst);
}

void nan_guards(Device& device, WorstError& worst) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> inputs = {kNan, 1.0f, -kNan, HUGE_VALF, -0.0f};
  const std::vector<double> values = probed(device, inputs, Probe::kIsNan);
  for (std::size_t i = 0; i < inputs.size(); ++i)
    worst.add(values[i], std::isnan(inputs[i]) ? 1.0 : 0.0, 1.0, fmt::format("input {}", inputs[i]));
}

void struct_layouts_agree(Device& device, WorstError& worst) {
  const StructLayout layout = struct_layout(device);
  for (std::size_t i = 0; i < layout.host.size(); ++i)
    worst.add(layout.device[i], layout.host[i], 1.0, fmt::format("size or offset {}", i));
}

SourceEdit probe_edit(const std::string& text, const std::string& replacement) {
  return {"probe_numerics", text, replacement};
}

std::vector<NumericalCase> exponential_cases() {
  return {
      {{"exp2-over-its-range", "device/numerics.clh",
        "if the exponent x is rounded towards zero, the remainder is outside the polynomial's range",
        "adding 1.5 * 2^23 rounds x to the nearest integer, and the result for signed zeros and denormal numbers is 1",
        3.5e-7, "relative error", "the polynomial's own error and its rounding add up to 2.2e-7"},
       exp2_in_range,
       {probe_edit("const real_v f = x - (shifted - 12582912.0f);", "const real_v f = x - trunc(x);")}},
      {{"exp2-far-below-its-range", "device/numerics.clh",
        "the exponent bits overflow, so the results become huge, negative or infinite",
        "x below -126 is replaced by -126, so the result is tiny but never denormal", 3.5e-7,
        "error in units of 2^-126", "the polynomial's own error and its rounding add up to 2.2e-7"},
       exp2_below_range,
       {probe_edit("exp2_in_range_v(MAX_V(x, (real_v)(-126.0f)))", "exp2_in_range_v(x)")}},
      {{"log2-of-every-normal", "device/numerics.clh", "a mantissa between 1 and 2 exceeds the range of the series",
        "the mantissa is kept between sqrt(1/2) and sqrt(2)", 1.0,
        "times the allowed error, which is 5e-7 + 6e-8 |log2 x|",
        "the series has an absolute error of its own, and rounding the result adds half a unit in the last place"},
       log2_of_normals,
       {},
       {},
       {probe_edit("0x3f3504f3", "0x3f800000")}},
      {{"log-of-one-minus-e", "device/vmf_shading.clh",
        "the cosine t = 1 - e has a rounding error of 6e-8, which the highlight exponent s = 1e5 multiplies",
        "below e = 0.1, log(1 - e) is computed by the series of -2 atanh(e / (2 - e))", 1e-6, "relative error",
        "the omitted terms of the series add only 3e-9, and four rounded operations follow"},
       one_minus_log,
       {probe_edit("return e > 0.1f ?", "return true ?")}},
  };
}

std::vector<NumericalCase> kappa_cases() {
  return {
      {{"kappa-of-mean-length-12-decades", "device/vmf.clh",
        "Banerjee's approximation (3r - r^3)/(1 - r^2) has an error of several per cent, and 1 - r^2 loses digits near "
        "r = 1",
        "kappa is computed as r G(r)/(1 - r), where G is a polynomial of degree 10, and the caller computes 1 - r as a "
        "sum of small terms",
        4e-5, "relative error", "the polynomial approximates kappa with an error of 3.3e-5"},
       kappa_of_mean_length,
       {probe_edit("return r * g / spread;", "return r * (3.0f - r * r) / (1.0f - r * r);")}},
      {{"log-peak-to-the-cap", "device/vmf.clh", "kappa / (exp(kappa) - exp(-kappa)) overflows above kappa = 89",
        "kappa / (1 - exp(-2 kappa)) does not overflow, and EM keeps kappa above 0.05, where the difference keeps its "
        "digits",
        4e-6, "absolute error of log2",
        "a logarithm near 20 has a rounding error of up to 1e-6, and at kappa = 0.05, the rounding error of exp, 6e-8, "
        "is divided by 0.095"},
       log_peak,
       {probe_edit("return log2_v(amplitude * kappa / (1.0f - exp2_v(kappa * (-2.0f * MULTUM_LOG2E))));",
                   "return log2(amplitude * kappa / (exp(kappa) - exp(-kappa))) + kappa * MULTUM_LOG2E;")}},
      {{"shading-kappa-12-decades", "device/vmf_shading.clh",
        "Banerjee's factor 3 - A^2, where A is the mean cosine, has an error of several per cent",
        "a polynomial refines the factor, and 1 - A^2 is computed as q (2 - q) with q = 1 - A, which avoids "
        "cancellation",
        2.4e-4, "relative error", "the polynomial approximates kappa with an error of 2.3e-4"},
       shading_kappa,
       {probe_edit("(3.0f - x + x * (1.0f - x) * p)", "(3.0f - x)")}},
      {{"shading-kappa-of-no-width", "device/vmf_shading.clh",
        "for a lobe of width 0, q is 0, and dividing by q gives an infinite kappa", "the denominator is at least 1e-12",
        kNothingWrong, "infinite or NaN results", "every result must be finite"},
       shading_kappa_of_nothing,
       {probe_edit("max(q * (2.0f - q), 1e-12f)", "(q * (2.0f - q))")}},
      {{"vmf-normaliser-12-decades", "device/vmf_shading.clh",
        "kappa / (1 - exp(-2 kappa)) divides 0 by 0 at kappa = 0",
        "below kappa = 1e-3, the approximation (1 + kappa) / 2 is used", 1e-4, "relative error",
        "at kappa = 1e-3, the divisor 1 - exp(-2 kappa) is only 2e-3, so the rounding error of exp2, 6e-8, grows to "
        "3e-5"},
       vmf_peak,
       {probe_edit("const real_v scale = kappa > 1e-3f ? kappa", "const real_v scale = true ? kappa")}},
      {{"vmf-spread-12-decades", "device/vmf_shading.clh",
        "near kappa = 0, the difference 1/kappa - 2/(exp(2 kappa) - 1) loses its digits by cancellation",
        "below kappa = 0.1, two terms of the series are used", 2e-5, "relative error",
        "at kappa = 0.1, two terms near 10 have a difference near 1, so its relative error is ten times the relative "
        "rounding error of a term"},
       vmf_spreads,
       {probe_edit("return kappa < 0.1f ?", "return false ?")}},
      {{"highlight-cosines-of-every-width", "device/vmf_shading.clh, probe_highlight_cosine",
        "the vectors of the facets and of an opposite lobe of equal sharpness cancel, so their sum has no direction",
        "the divisor is at least 1e-6", 2.5e-3, "absolute error",
        "the model of the mean cosine has an error of 0.22 %"},
       highlight_cosines,
       {probe_edit("max(size, 1e-6f)", "size")}},
  };
}

}  // namespace

std::vector<NumericalCase> numerics_cases() {
  std::vector<NumericalCase> cases = exponential_cases();
  for (NumericalCase& c : kappa_cases()) cases.push_back(std::move(c));
  cases.push_back(
      {{"driver-keeps-nan", "probe_functions",
        "with -cl-finite-math-only, isnan() returns false for NaN, so guards that test for NaN have no effect",
        "no compiler option relaxes floating-point rules (host/formats/opencl/build_options)", kNothingWrong,
        "wrong answers", "every answer must be correct"},
       nan_guards,
       {},
       {},
       {probe_edit("isnan(x) ? 1.0f : 0.0f", "0.0f")}});
  cases.push_back({{"driver-lays-structs-out-alike", "probe_layout",
                    "every struct field after a padding gap is read from the wrong offset",
                    "structs contain only ints and floats, never float3, bool or size_t", kNothingWrong,
                    "bytes of difference", "host and device must use the same offsets"},
                   struct_layouts_agree,
                   {},
                   {},
                   {probe_edit("int first_row;\n", "long first_row;\n")}});
  return cases;
}

}  // namespace multum
