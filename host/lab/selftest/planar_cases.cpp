// SPDX-License-Identifier: Apache-2.0
// Tests planar Gaussians (Tan et al. 2005), the lobe kernels built with MULTUM_PLANAR, and the rounding of Gaussians.
// The inputs are difficult for a Gaussian over (n_x, n_y). They contain small variances near the rim, variances of 0,
// and lobes without normals.
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/foundation/base/split_mix.h"
#include "host/lab/reference/planar_em.h"
#include "host/lab/selftest/buffers.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"
#include "host/lab/selftest/shade_launch.h"
#include "kernels/shared/movmf_fit.h"

namespace multum {
namespace {

EmSettings planar_settings(int iterations) {
  EmSettings settings;
  settings.planar = true;
  settings.iterations = iterations;
  return settings;
}

glm::dvec3 point(double degrees, double azimuth = 0.3) {
  const glm::dvec3 n = tilted(degrees, azimuth);
  return {n.x, n.y, 0.0};
}

constexpr double kTilts[] = {0.0, 30.0, 60.0, 80.0, 89.0, 90.0};

// Returns a texel with a thousand normals. The angles between the normals and one tilted direction are at most about
// `width` degrees.
EmTexel narrow_texel(double degrees, double width) {
  EmTexel texel{{}, equal_lobes({point(degrees)}, 100.0)};
  for (int i = 0; i < 1000; ++i)
    texel.samples.push_back({point(degrees + width * (i % 5 - 2) / 2.0, 0.3 + 0.01 * width * (i % 7 - 3)), 1.0});
  return texel;
}

void variance_at_the_rim(Device& device, WorstError& worst) {
  for (const double degrees : kTilts)
    for (const double width : {4.0, 1.0, 0.25}) {
      const EmTexel texel = narrow_texel(degrees, width);
      const double expected = fit_in_double(texel, planar_settings(4)).lobes[0].z;
      for (const EmForm form : em_forms(device))
        worst.add(fit_texels(device, {texel}, planar_settings(4), form).front().lobes[0].z, expected, expected,
                  fmt::format("{} degrees, {} wide, sigma^2 {:.2g}", degrees, width, expected));
    }
}

// Tests one repeated point and a distant mean. Except for rounding, the mean squared distance from the mean equals the
// squared shift of the mean (Steiner's theorem).
void variance_never_negative(Device& device, WorstError& worst) {
  for (int i = 0; i < 60; ++i) {
    const EmTexel texel = {repeated({point(1.5 * i, 0.1 * i)}, 7), equal_lobes({point(89.0 - i, 2.0)}, 3.0)};
    for (const EmForm form : em_forms(device))
      worst.add(std::max(-fit_texels(device, {texel}, planar_settings(1), form).front().lobes[0].z, 0.0),
                fmt::format("point {}", i));
  }
}

// Tests points at which every density is 0 in float.
void far_from_every_gaussian(Device& device, WorstError& worst) {
  for (const double kappa : {1e3, 1e5, 1e6})
    add_em_errors(device,
                  {repeated({point(60, 0.1), point(60, 1.4)}, 64), equal_lobes({point(10), point(10, 1.5)}, kappa)},
                  planar_settings(2), fmt::format("kappa {}", kappa), worst);
}

// Tests a lobe that gets no normals, and a lobe that gets one normal in a thousand.
void dying_gaussians(Device& device, WorstError& worst) {
  EmTexel texel{repeated({point(5, 0.0), point(7, 2.0), point(6, 4.0)}, 999),
                equal_lobes({point(5, 0.0), point(70, 1.0), point(80, 4.0)}, 300.0)};
  texel.samples.push_back({point(70, 1.0), 1.0});
  add_em_errors(device, texel, planar_settings(8), "1 in 1000", worst);
  texel.samples.back().normal = point(6.0, 1.0);
  add_em_errors(device, texel, planar_settings(8), "none", worst);
}

// Tests texels with more lobes than points, and texels with equal lobes and one repeated point.
void few_points(Device& device, WorstError& worst) {
  for (const int count : {1, 2, 3})
    for (const int lobes : em_lobe_counts(device, {2, 1, 8})) {
      EmTexel texel;
      for (int i = 0; i < count; ++i) texel.samples.push_back({point(25.0 * i, 1.0 * i), 1.0});
      std::vector<glm::dvec3> starts;
      for (int j = 0; j < lobes; ++j) starts.push_back(point(9.0 * j, 0.5 * j));
      texel.lobes = equal_lobes(starts, 30.0);
      add_em_errors(device, texel, planar_settings(5), fmt::format("N = {}, {} lobes", count, lobes), worst);
    }
  for (const double degrees : kTilts)
    for (const int lobes : em_lobe_counts(device, {2, 1, 8})) {
      const std::vector<glm::dvec3> starts(static_cast<std::size_t>(lobes), point(degrees - 5.0));
      add_em_errors(device, {repeated({point(degrees)}, 256), equal_lobes(starts, 20.0)}, planar_settings(5),
                    fmt::format("one point at {} degrees, {} equal lobes", degrees, lobes), worst);
    }
}

// Tests the upper limit of 1/sigma^2 in a texel with three lobes. Two lobes share the points, and the third lobe has no
// points. The sums are the results of an E-step, relative to mu.
void caps_of_narrow_texels(Device& device, WorstError& worst) {
  constexpr std::size_t kChunks = 64, kSums = 5;
  for (const double degrees : kTilts)
    for (const double width : {0.0, 0.01, 0.25, 1.0, 10.0})
      for (const double apart : {0.0, 3.0}) {
        const EmTexel texel{{}, equal_lobes({point(degrees - apart), point(degrees + apart), point(10.0, 3.0)}, 100.0)};
        std::vector<float> partial(kGroup * kChunks * 3 * kSums, 0.0f);
        glm::dvec2 mean(0.0);
        std::vector<glm::dvec2> points;
        for (std::size_t i = 0; i < kChunks; ++i) {
          points.emplace_back(glm::vec2(point(degrees + width * (static_cast<double>(i % 5) / 2.0 - 1.0))));
          mean += points.back() / static_cast<double>(kChunks);
        }
        double variance = 0.0;
        for (std::size_t i = 0; i < kChunks; ++i) {
          variance += 0.5 * glm::dot(points[i] - mean, points[i] - mean) / kChunks;
          const std::size_t j = i % 2;
          const glm::dvec2 d = points[i] - glm::dvec2(glm::vec2(texel.lobes[j].mu));
          float* sums = &partial[(i * 3 + j) * kSums];
          const double values[kSums] = {1.0, points[i].x, points[i].y, 0.0, 0.5 * glm::dot(d, d)};
          for (std::size_t k = 0; k < kSums; ++k) sums[k] = static_cast<float>(values[k]);
        }
        MultumMovmfFit fit = {};
        fit.slot_count = MULTUM_GROUP;
        fit.chunk_count = kChunks;
        fit.total_weight_inverse = 1.0f / kChunks;
        fit.kappa_cap = 500.0f;
        fit.kappa_cap_slope = 10.0f;
        std::vector<int> list(kGroup, -1);
        list[0] = 0;
        const DeviceBuffer start = uploaded(device, packed_start({texel}, true), "start");
        device.kernel("movmf_em_mstep", "movmf_em_cap", {3, 1, false, true})
            .launch({kGroup}, uploaded(device, partial, "partial sums"), start, uploaded(device, list, "texels"), fit);
        const std::vector<float> found = downloaded<float>(device, start);
        const double cap = std::min(500.0 + 10.0 / std::max(variance, 1e-6), 1e6);
        for (std::size_t j = 0; j < 3; ++j) {
          const float* caps = &found[(j * MULTUM_START_PLANES + MULTUM_START_CAP) * kGroup];
          const std::string input = fmt::format("{} degrees, {} wide, mu {} apart", degrees, width, apart);
          worst.add(static_cast<double>(caps[0]), cap, cap, input);
          worst.add(static_cast<double>(caps[1]), 0.0, 1.0, input + ": a slot without a texel");
        }
      }
}

// Tests the scatter that movmf_bin_means computes for cells of equal normals at any tilt.
void scatter_of_equal_normals(Device& device, WorstError& worst) {
  constexpr int kCells = 400;
  std::vector<std::int64_t> cells;
  for (int i = 0; i < kCells; ++i) {
    const glm::vec3 n(tilted(0.225 * i, 0.1 * i));
    const int count = 1 + i % 37;
    for (const float value : {n.x, n.y, n.x * n.x + n.y * n.y, 1.0f})
      cells.push_back(count * static_cast<std::int64_t>(value * 0x1p30f));
  }
  const DeviceBuffer in = device.wrap_buffer(cells.data(), cells.size() * sizeof(std::int64_t), "cells");
  std::vector<float> samples(kCells * MULTUM_CONDENSED_SAMPLE, NAN);
  DeviceBuffer out = device.make_buffer(samples.size() * sizeof(float), "samples");
  device.write(out, samples.data(), out.byte_count());
  const DeviceBuffer counts = device.make_buffer(sizeof(int), "counts");
  device.kernel("movmf_binning", "movmf_bin_means", {1, 1, false, true}).launch({1}, in, out, counts, 1, 1, kCells, 1);
  device.read(out, samples.data(), out.byte_count());
  for (std::size_t i = 0; i < kCells; ++i)
    worst.add(std::max(-static_cast<double>(samples[i * MULTUM_CONDENSED_SAMPLE + 2]), 0.0) +
                  0.0 * static_cast<double>(samples[i * MULTUM_CONDENSED_SAMPLE + 2]),
              fmt::format("cell {}", i));
}

std::vector<glm::vec4> directions_around(double degrees) {
  std::vector<glm::vec4> directions;
  for (int i = -10; i <= 10; ++i) directions.emplace_back(glm::vec3(tilted(degrees + 2.0 * i)), 0.0f);
  return directions;
}

// Compares the shading with the formula in double precision, relative to the peak of an upright lobe.
void add_density(Device& device, const glm::vec4& lobe, double s, const std::vector<glm::vec4>& directions,
                 const std::string& input, WorstError& worst) {
  const glm::dvec4 wide(lobe);
  const double amplitude = wide.w, peak = amplitude * (s + 3.0) / (2.0 * M_PI);
  const std::vector<double> values = shade_lobe(device, lobe, static_cast<float>(s), directions, true);
  for (std::size_t i = 0; i < values.size(); ++i)
    worst.add(values[i], reference::gmm_density(wide, s, glm::dvec3(directions[i])), peak, input);
}

// Tests lobes whose third value is less than the square of the mean. Rounding and filtering can produce these lobes.
void filtered_variance_below_0(Device& device, WorstError& worst) {
  for (const double degrees : {0.0, 30.0, 60.0, 89.0})
    for (const float missing : {0.0f, 1e-6f, 3e-5f, 5e-4f})
      for (const double s : {20.0, 500.0, 1e4}) {
        const glm::vec3 p(point(degrees));
        add_density(device, {p.x, p.y, p.x * p.x + p.y * p.y - missing, 1.0f}, s, directions_around(degrees),
                    fmt::format("{} degrees, {} missing, s {}", degrees, missing, s), worst);
      }
}

void vanishing_gaussian(Device& device, WorstError& worst) {
  const std::vector<glm::vec4> directions = directions_around(30.0);
  for (const float amplitude : {0.5f, 1e-3f, 2e-6f, 1e-6f, 1e-8f, 1e-40f, 0.0f}) {
    const glm::vec3 p = glm::vec3(point(30.0)) * amplitude;
    const glm::vec4 lobe(p.x, p.y, 0.3f * amplitude, amplitude);
    if (amplitude > 1e-6f) {
      add_density(device, lobe, 100.0, directions, fmt::format("amplitude {}", amplitude), worst);
      continue;
    }
    for (const float s : {0.0f, 100.0f})
      for (const double value : shade_lobe(device, lobe, s, directions, true))
        worst.add(value == 0.0 ? 0.0 : 1.0 + 0.0 * value, fmt::format("amplitude {}", amplitude));
  }
}

// Tests the stored 2 sigma^2 of lobes with amplitude 1 at the limit of an encoding. Also tests that the spread of
// single directions stays 0.
void stored_variance(StorageEncoding encoding, bool naive, WorstError& worst) {
  SplitMix64 random(2005);
  for (const double variance : {0.0, 1.0 / static_cast<double>(gmm_kappa_max(encoding))}) {
    MovmfLevel level{2000, 1, {{}}, {}};
    for (int i = 0; i < level.width; ++i) {
      // For unit vectors, E|p|^2 is at most 1.
      const glm::dvec3 p = std::sqrt(1.0 - 2.0 * variance) * point(90.0 * random.uniform(), 6.28 * random.uniform());
      level.lobes[0].emplace_back(glm::dvec4(p.x, p.y, 2.0 * variance + p.x * p.x + p.y * p.y, 1.0));
    }
    if (!naive) quantize_gmm(level, encoding, 1);
    for (std::size_t i = 0; i < 2000; ++i) {
      glm::vec4& lobe = level.lobes[0][i];
      for (int k = 0; naive && k < 3; ++k)
        lobe[k] = encoding == StorageEncoding::kHalf ? static_cast<float>(half(lobe[k]))
                                                     : std::round(lobe[k] * 32767.0f) / 32767.0f;
      const double found = static_cast<double>(gmm_variance(lobe));
      if (variance > 0.0) worst.add(found, variance, variance, fmt::format("lobe {}", i));
      else worst.add(found, fmt::format("single direction {}", i));
    }
  }
}

NumericalCase storage_case(StorageEncoding encoding, const std::string& name) {
  return {
      {"planar-variance-in-" + name, "gmm_quantize",
       "near the unit circle, twice the variance is the difference of two rounded numbers near 1, so all digits cancel",
       "the encoder rounds the mean square last, so that it matches the rounded mean, and rounds it down for single "
       "directions",
       0.251, "error of the variance (relative at the encoding's limit, absolute for single directions)",
       "at the encoding's limit, rounding the mean square changes the variance by up to a quarter of its value"},
      [=](Device&, WorstError& worst) { stored_variance(encoding, false, worst); },
      {},
      [=](WorstError& worst) { stored_variance(encoding, true, worst); }};
}

std::vector<NumericalCase> fit_cases() {
  const SourceEdit no_floor = em_edit("MAX_V(fitted, (real_v)(SPREAD_MIN))", "fitted");
  const SourceEdit no_cap = em_edit("kappa = MIN_V(MAX_V(kappa, (real_v)(KAPPA_MIN)), kappa_max);", "");
  const char* const kFormula = "movmf_em_texels (planar)";
  const char* const kUnit = "absolute error of the amplitude a, of a times the mean, and of a times the variance";
  return {
      {{"planar-variance-at-the-rim", kFormula,
        "for points p near the unit circle, the difference E|p|^2 - |E p|^2 loses its digits by cancellation",
        "the kernel computes the mean squared distance from the previous mean, minus the squared shift of the mean "
        "(Steiner's theorem)",
        1e-4, "relative error of sigma^2", "the rounding errors of a thousand additions add up"},
       variance_at_the_rim,
       {em_edit("const real_v spread = fma(d, inverse, -half_square(m.x - mu_x, m.y - mu_y));",
                "const real_v spread = (d * inverse + (m.x * mu_x + m.y * mu_y - half_square(mu_x, mu_y))) - "
                "half_square(m.x, m.y);")}},
      {{"planar-variance-never-negative", kFormula,
        "rounding makes the variance of equal points negative, so the density is undefined",
        "the variance is at least 0", kNothingWrong, "deviation below 0", "no result may be negative"},
       variance_never_negative,
       {em_edit("m.spread = MIN_V(MAX_V(spread, (real_v)(0.0f)), (real_v)(1.0f));", "m.spread = spread;")}},
      {{"planar-far-from-every-lobe", kFormula,
        "every density is 0 in float, so the shares of the lobes are 0 divided by 0",
        "the kernel computes logarithms of densities and subtracts the largest logarithm", 1e-4, kUnit,
        "logarithms near 1e6 have relative rounding errors of 6e-8, which change the shares"},
       far_from_every_gaussian,
       {em_edit("exp2_in_range_v(MAX_V(e[j] - largest, (real_v)(LOG_SHARE_MIN)))", "exp2(e[j])")}},
      {{"planar-lobes-that-die", kFormula,
        "the binary exponent of a share such as 2^-1000 overflows and wraps around, so a tiny share becomes a large "
        "number",
        "each share is at least 2^-100 times the largest share, and a lobe with an amplitude below 1e-7 keeps its mean "
        "and variance",
        1e-5, kUnit, kEmBoundReason},
       dying_gaussians,
       {em_edit("MAX_V(e[j] - largest, (real_v)(LOG_SHARE_MIN))", "(e[j] - largest)")}},
      {{"planar-one-two-three-points", kFormula,
        "if there are more lobes than points, a variance is 0 and its inverse is infinite",
        "the variance is at least 1e-7, and its inverse is at most 500 + 10 kappa_1, where kappa_1 fits all normals of "
        "the texel",
        1e-4, kUnit,
        "several equal lobes share a point, and each iteration amplifies the small differences between the lobes"},
       few_points,
       {},
       {},
       {no_floor, no_cap}},
      {{"planar-caps-of-narrow-texels", "movmf_em_cap", "the mean of a lobe without points is 0 divided by 0",
        "the divisor is at least 1e-30, and the variance is at least 1e-6", 2e-4,
        "relative error of the upper limit of 1/sigma^2",
        "the squared distance of points 3 degrees apart has a relative error of 1.2e-7, which matters next to a "
        "variance of only 1e-6"},
       caps_of_narrow_texels,
       {{"movmf_em_mstep", "1.0f / MAX_V(sum_s[j], (real_v)(1e-30f))", "1.0f / sum_s[j]"}}},
      {{"planar-scatter-of-equal-normals", "movmf_bin_means (planar)",
        "for the points p of a cell, rounding makes E|p|^2 smaller than the squared mean", "the variance is at least 0",
        kNothingWrong, "deviation below 0", "no result may be negative"},
       scatter_of_equal_normals,
       {{"movmf_binning", "MAX_V(mean.z - fma(mean.x, mean.x, mean.y * mean.y), 0.0f)",
         "mean.z - fma(mean.x, mean.x, mean.y * mean.y)"}}},
  };
}

}  // namespace

std::vector<NumericalCase> planar_cases() {
  std::vector<NumericalCase> cases = fit_cases();
  cases.push_back({{"planar-filtered-variance-below-0", "movmf_shade (planar)",
                    "after rounding and filtering, the stored mean square is below the square of the mean, so the "
                    "variance is negative",
                    "the lobe's variance is at least 0, so in the worst case only the facets' variance remains", 2e-3,
                    "of the peak of an upright lobe",
                    "a mean near 1 is rounded twice, which changes a variance of 1e-4 by up to 1.2e-7, or 0.12 %"},
                   filtered_variance_below_0,
                   {shade_edit("max(spread, 0.0f)", "spread")}});
  cases.push_back({{"planar-amplitude-to-0", "movmf_shade (planar)",
                    "the moments of a lobe without normals are divided by the lobe's amplitude, which is 0",
                    "lobes with amplitudes up to 1e-6 are ignored", 6e-4,
                    "of the peak of an upright lobe (light that must be 0 counts as an error of 1)",
                    "a mean near 1 is rounded twice, which changes a variance of 1e-4 by up to 1.2e-7, or 0.12 %"},
                   vanishing_gaussian,
                   {shade_edit("shape.amplitude = lobe.w <= GMM_AMPLITUDE_MIN ? (real_v)(0.0f) : lobe.w;",
                               "shape.amplitude = lobe.w;"),
                    shade_edit("lobe.w <= GMM_AMPLITUDE_MIN ? (real_v)(0.0f) : ", "")}});
  cases.push_back(storage_case(StorageEncoding::kHalf, "half"));
  cases.push_back(storage_case(StorageEncoding::kSnorm16, "snorm16"));
  return cases;
}

}  // namespace multum
