// SPDX-License-Identifier: Apache-2.0
// Tests EM in one work-item (kernels/movmf_em_texels.cl) with samples for which formulas without guards fail (Han et
// al. 2007, section 7, Algorithm 1, equations 15-16; docs/contributing/ALGORITHMS.md, "Fitting a texel: EM").
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "host/foundation/base/split_mix.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"

namespace multum {
namespace {

glm::dvec3 random_direction(SplitMix64& random, double z_low, double z_high) {
  const double z = z_low + (z_high - z_low) * random.uniform(), phi = 2.0 * M_PI * random.uniform();
  return {std::sqrt(1.0 - z * z) * std::cos(phi), std::sqrt(1.0 - z * z) * std::sin(phi), z};
}

// Tests a texel with more lobes than directions, in which all lobes are equal.
void all_normals_equal(Device& device, WorstError& worst) {
  for (const double degrees : {0.0, 30.0, 60.0, 89.0, 90.0})
    for (const int lobes : em_lobe_counts(device, {4, 1, 8})) {
      const std::vector<glm::dvec3> starts(static_cast<std::size_t>(lobes), tilted(degrees + 5.0));
      add_em_errors(device, {repeated({tilted(degrees)}, 256), equal_lobes(starts, 20.0)}, {},
                    fmt::format("{} degrees, {} lobes", degrees, lobes), worst);
    }
}

// Tests two lobes that converge to two single directions. Without an upper limit, kappa would grow without bound.
void kappa_to_the_cap(Device& device, WorstError& worst) {
  for (const double apart : {1.0, 10.0, 90.0, 179.8})
    for (const float cap : {500.0f, 1e5f}) {
      EmSettings settings;
      settings.iterations = 12;
      settings.kappa_cap = cap;
      const glm::dvec3 a = tilted(0.5 * apart, 0.0), b = tilted(0.5 * apart, M_PI);
      add_em_errors(device,
                    {repeated({a, b}, 256), equal_lobes({tilted(0.4 * apart, 0.0), tilted(0.4 * apart, M_PI)}, 50.0)},
                    settings, fmt::format("{} degrees apart, cap {}", apart, cap), worst);
    }
}

// Tests the kappa that EM computes for normals whose angles to their mean are at most `width`.
void sharp_lobes_keep_their_kappa(Device& device, WorstError& worst) {
  for (const double width : {1.0, 0.5, 0.25}) {
    EmTexel texel{{}, equal_lobes({tilted(40.0)}, 100.0)};
    for (int i = 0; i < 1000; ++i)
      texel.samples.push_back({tilted(40.0 + width * (i % 5 - 2) / 2.0, 0.3 + 0.01 * width * (i % 7 - 3)), 1.0});
    EmSettings settings;
    settings.iterations = 3;
    settings.kappa_cap = 1e5f;
    settings.kappa_cap_slope = 1000.0f;
    const double expected = fit_in_double(texel, settings).kappa[0];
    for (const EmForm form : em_forms(device))
      worst.add(1.0 / fit_texels(device, {texel}, settings, form).front().kappa[0], 1.0 / expected, 1.0,
                fmt::format("{} degrees wide, kappa {:.3g}", width, expected));
  }
}

// Fits one lobe to normals that cancel. The r of the lobe is 0, so the lobe has no direction, and kappa approaches 0.
void opposite_normals_of_one_lobe(Device& device, WorstError& worst) {
  const std::vector<std::vector<glm::dvec3>> sets = {
      {{1, 0, 0}, {-1, 0, 0}}, {{0, 0, 1}, {0, 0, -1}}, {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}};
  for (std::size_t s = 0; s < sets.size(); ++s)
    for (const double kappa : {0.05, 1.0, 100.0})
      add_em_errors(device, {repeated(sets[s], 64), equal_lobes({{0.6, 0.0, 0.8}}, kappa)}, {},
                    fmt::format("set {}, start kappa {}", s, kappa), worst);
}

void whole_sphere(Device& device, WorstError& worst) {
  SplitMix64 random(71);
  for (const double z_low : {-1.0, -0.5}) {
    EmTexel texel{{}, equal_lobes({tilted(20), tilted(100), tilted(150, 2.0), tilted(80, 4.0)}, 2.0)};
    for (int i = 0; i < 512; ++i)
      texel.samples.push_back({random_direction(random, z_low, z_low == -1.0 ? 1.0 : 0.0), 1.0});
    add_em_errors(device, texel, {}, fmt::format("z from {}", z_low), worst);
  }
}

// Tests normals that are as far as possible from every lobe. Kappa has its largest value, so every density is 0 in
// float.
void far_from_every_lobe(Device& device, WorstError& worst) {
  for (const double kappa : {1e3, 1e5, 1e6}) {
    EmTexel texel{repeated({tilted(60, 0.1), tilted(60, 1.4)}, 64),
                  equal_lobes({tilted(10, 0.0), tilted(10, 1.5)}, kappa)};
    EmSettings settings;
    settings.iterations = 2;
    add_em_errors(device, texel, settings, fmt::format("kappa {}", kappa), worst);
  }
}

// Tests a lobe that gets no normals, and a lobe that gets one normal in a thousand.
void dying_lobes(Device& device, WorstError& worst) {
  EmTexel texel{repeated({tilted(5, 0.0), tilted(7, 2.0), tilted(6, 4.0)}, 999),
                equal_lobes({tilted(5, 0.0), tilted(70, 1.0), tilted(80, 4.0)}, 300.0)};
  texel.samples.push_back({tilted(70, 1.0), 1.0});
  EmSettings settings;
  settings.iterations = 8;
  add_em_errors(device, texel, settings, "1 in 1000", worst);
  texel.samples.back().normal = tilted(6.0, 1.0);
  add_em_errors(device, texel, settings, "none", worst);
}

void few_normals(Device& device, WorstError& worst) {
  for (const int count : {1, 2, 3})
    for (const int lobes : em_lobe_counts(device, {2, 1, 8})) {
      EmTexel texel;
      for (int i = 0; i < count; ++i) texel.samples.push_back({tilted(25.0 * i, 1.0 * i), 1.0});
      std::vector<glm::dvec3> starts;
      for (int j = 0; j < lobes; ++j) starts.push_back(tilted(9.0 * j, 0.5 * j));
      texel.lobes = equal_lobes(starts, 30.0);
      add_em_errors(device, texel, {}, fmt::format("N = {}, {} lobes", count, lobes), worst);
    }
}

// Tests normals with lengths below, at and above 1. Mean normals of rough areas are shorter than 1. If a normal has
// length 0 or is longer than 1, the caller has made an error.
void samples_of_any_length(Device& device, WorstError& worst) {
  for (const double length : {0.0, 1e-20, 1e-3, 0.5, 0.999999, 1.000001, 1.5}) {
    EmTexel texel{{}, equal_lobes({tilted(10), tilted(50)}, 20.0)};
    for (int i = 0; i < 200; ++i) texel.samples.push_back({length * tilted(i % 60, 0.1 * i), 1.0});
    EmSettings settings;
    settings.iterations = 4;
    if (length <= 1.0) {
      add_em_errors(device, texel, settings, fmt::format("length {}", length), worst);
      continue;
    }
    // The reference does not clamp r, but the stored r is never longer than 1.
    for (const EmForm form : em_forms(device)) {
      const std::vector<FittedTexel> found = fit_texels(device, {texel}, settings, form);
      for (const glm::dvec4& lobe : found.front().lobes)
        worst.add(std::fmax(glm::length(glm::dvec3(lobe)) - 1.0, 0.0) + 0.0 * lobe.w, fmt::format("length {}", length));
    }
  }
}

// Tests NaN, infinite and huge normals in one of sixteen texels. No bit of the other fifteen texels may change.
void a_bad_texel_stays_alone(Device& device, WorstError& worst) {
  constexpr double kInf = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<EmTexel> good;
  for (int t = 0; t < 16; ++t)
    good.push_back(
        {repeated({tilted(3.0 * t), tilted(40.0, 0.2 * t)}, 64), equal_lobes({tilted(10), tilted(45)}, 10.0)});
  EmSettings settings;
  settings.iterations = 8;
  settings.convergence_tolerance = 0.01f;
  for (const EmForm form : em_forms(device)) {
    const std::vector<FittedTexel> expected = fit_texels(device, good, settings, form);
    for (const double bad : {kNan, kInf, -kInf, 1e38}) {
      std::vector<EmTexel> texels = good;
      texels[0].samples[5].normal = glm::dvec3(bad, 0.0, 1.0);
      const std::vector<FittedTexel> found = fit_texels(device, texels, settings, form);
      for (std::size_t t = 1; t < 16; ++t)
        for (std::size_t j = 0; j < 2; ++j)
          worst.add(found[t].lobes[j] == expected[t].lobes[j] ? 0.0 : 1.0,
                    fmt::format("a normal of {}, texel {}", bad, t));
    }
  }
}

// Tests components that are -0, denormal, or the smallest normal number.
void denormals_and_signed_zeros(Device& device, WorstError& worst) {
  for (const double tiny : {0.0, -0.0, 1e-45, -1e-40, 1.2e-38, 1e-30}) {
    EmTexel texel{repeated({{tiny, -0.0, 1.0}, {-0.0, tiny, 1.0}, {0.6, tiny, 0.8}}, 96),
                  equal_lobes({{tiny, -0.0, 1.0}, {0.5, tiny, 0.866}}, 10.0)};
    texel.lobes[1].amplitude = std::abs(tiny);
    add_em_errors(device, texel, {}, fmt::format("component {}", tiny), worst);
  }
}

// Tests weights from 2^-28 to 1 in one texel, as they occur in a binned texel of 2^28 normals.
void huge_and_tiny_weights(Device& device, WorstError& worst) {
  for (const double scale : {0x1p-30, 1.0, 0x1p28}) {
    EmTexel texel{{}, equal_lobes({tilted(10, 0.0), tilted(50, 2.0)}, 20.0)};
    for (int i = 0; i < 120; ++i) texel.samples.push_back({tilted(i % 70, 0.2 * i), scale * std::exp2(-(i % 29))});
    add_em_errors(device, texel, {}, fmt::format("weights of {:.3g}", scale), worst);
  }
}

std::vector<NumericalCase> sharp_cases() {
  const SourceEdit no_floor = em_edit("MAX_V(m.spread, (real_v)(1e-7f))", "m.spread");
  const SourceEdit no_cap = em_edit("kappa = MIN_V(MAX_V(kappa, (real_v)(KAPPA_MIN)), kappa_max);", "");
  const SourceEdit no_least_share = em_edit("MAX_V(e[j] - largest, (real_v)(LOG_SHARE_MIN))", "(e[j] - largest)");
  return {
      {{"all-normals-equal-and-all-lobes", "movmf_em_texels, movmf_em_team",
        "the spread is 0 and kappa is infinite, so the product of spread and kappa is NaN",
        "the spread is at least 1e-7, and kappa is at most 500 + 10 kappa_1, where kappa_1 fits all normals of the "
        "texel",
        4e-6, "absolute error of the lobe's amplitude a and of the vector a r",
        "all 256 equal additions can be rounded in the same direction, which gives an error of a few 1e-6"},
       all_normals_equal,
       {},
       {},
       {no_floor, no_cap, no_least_share}},
      {{"kappa-to-the-cap", "movmf_em_texels, movmf_em_team",
        "each lobe contains only one direction, so kappa grows without bound",
        "the spread is at least 1e-7, and kappa is at most 500 + 10 kappa_1, where kappa_1 fits all normals of the "
        "texel",
        4e-6, "absolute error of the lobe's amplitude a and of the vector a r",
        "all 256 equal additions can be rounded in the same direction, which gives an error of a few 1e-6"},
       kappa_to_the_cap,
       {},
       {},
       {no_floor, no_cap}},
      {{"kappa-of-sharp-lobes", "movmf_em_texels, movmf_em_team",
        "|r| is computed from a sum of a thousand rounded normals, so 1 - |r| has no correct digit at kappa = 1e5",
        "the spread is the mean of 1 - n . mu over the normals n, corrected for the rotation of the direction mu", 3e-7,
        "absolute error of 1/kappa",
        "the length of mu has a rounding error of at most 6e-8, and 1 - n . mu has an error of at most 1.2e-7"},
       sharp_lobes_keep_their_kappa,
       {em_edit("const real_v spread = fma(-length, turn, d * inverse);", "const real_v spread = 1.0f - length;")}},
      {{"far-from-every-lobe", "movmf_em_texels, movmf_em_team",
        "every density is 0 in float, so the shares of the lobes are 0 divided by 0",
        "the kernel computes logarithms of densities and subtracts the largest logarithm", 1e-4,
        "absolute error of the lobe's amplitude a and of the vector a r",
        "logarithms near 1e6 have relative rounding errors of 6e-8, which change the shares"},
       far_from_every_lobe,
       {em_edit("exp2_in_range_v(MAX_V(e[j] - largest, (real_v)(LOG_SHARE_MIN)))", "exp2(e[j])")}},
  };
}

std::vector<NumericalCase> wide_cases() {
  return {
      {{"opposite-normals-of-one-lobe", "movmf_em_texels, movmf_em_team",
        "a mean r of length 0 has no direction, and normalising it divides by zero",
        "the lobe keeps its last direction", 4e-6, "absolute error of the lobe's amplitude a and of the vector a r",
        "64 additions are rounded, and their errors add up"},
       opposite_normals_of_one_lobe,
       {},
       {},
       {em_edit("sqrt(MAX_V(squared, (real_v)(1e-30f)))", "sqrt(squared)"),
        em_edit("directed ? x * length_inverse : mu_x", "x * length_inverse")}},
      {{"the-equator-and-below", "movmf_em_texels, movmf_em_team",
        "the x and y of a normal do not show whether the normal is in the lower or the upper hemisphere",
        "the kernel stores directions as 3D vectors, whose z can be negative", 1e-5,
        "absolute error of the lobe's amplitude a and of the vector a r", kEmBoundReason},
       whole_sphere,
       {},
       {},
       {em_edit("fma(-mu_z, z,", "fma(-mu_z, fabs(z),")}},
      {{"lobes-that-die", "movmf_em_texels, movmf_em_team",
        "the binary exponent of a share such as 2^-1000 overflows and wraps around, so a tiny share becomes a large "
        "number",
        "each share is at least 2^-100 times the largest share, and a lobe with an amplitude below 1e-7 keeps its "
        "direction and spread",
        1e-5, "absolute error of the lobe's amplitude a and of the vector a r", kEmBoundReason},
       dying_lobes,
       {em_edit("MAX_V(e[j] - largest, (real_v)(LOG_SHARE_MIN))", "(e[j] - largest)")}},
  };
}

std::vector<NumericalCase> input_cases() {
  return {
      {{"one-two-three-normals", "movmf_em_texels, movmf_em_team",
        "if a texel has more lobes than normals, some lobes have a spread of 0",
        "the kernel limits the spread to a minimum and kappa to a maximum", 1e-4,
        "absolute error of the lobe's amplitude a and of the vector a r",
        "if eight lobes share two normals, each iteration amplifies the small differences between the lobes"},
       few_normals,
       {},
       {},
       {em_edit("MAX_V(m.spread, (real_v)(1e-7f))", "MAX_V(m.spread, (real_v)(1e-1f))")}},
      {{"normals-of-any-length", "movmf_em_texels, movmf_em_team",
        "normals longer than 1 can make |r| larger than 1, so the spread 1 - |r| is negative",
        "the spread is clamped to the range 0 to 1", 1e-5,
        "absolute error of the lobe's amplitude a and of the vector a r (or the excess of |r| over 1)", kEmBoundReason},
       samples_of_any_length,
       {em_edit("m.spread = MIN_V(MAX_V(spread, (real_v)(0.0f)), (real_v)(1.0f));", "m.spread = spread;")}},
      {{"a-bad-texel-stays-alone", "movmf_em_texels, movmf_em_team",
        "a NaN, infinite or huge normal affects neighbouring texels",
        "lanes share no data and stop independently; multum also repairs invalid normals when it reads maps "
        "(docs/reference/input_maps.md)",
        kNothingWrong, "changed texels", "no bit may change"},
       a_bad_texel_stays_alone,
       {},
       {},
       {em_edit("moving = moving & (change > fit.convergence_tolerance_squared);",
                "moving = moving & (change > fit.convergence_tolerance_squared); first_sample = samples;")}},
      {{"denormals-and-signed-zeros", "movmf_em_texels, movmf_em_team",
        "the logarithm of a denormal amplitude is either -149 or undefined",
        "the E-step replaces amplitudes below 1e-6 by 1e-6", 1e-5,
        "absolute error of the lobe's amplitude a and of the vector a r", kEmBoundReason},
       denormals_and_signed_zeros,
       {},
       {},
       {em_edit("#define AMPLITUDE_MIN 1e-6f", "#define AMPLITUDE_MIN 1e-1f")}},
      {{"weights-from-tiny-to-huge", "movmf_em_texels, movmf_em_team",
        "the minimum of the divisor exceeds sums of small weights, so mean normals become too short",
        "the divisor is at least 1e-30", 1e-5, "absolute error of the lobe's amplitude a and of the vector a r",
        kEmBoundReason},
       huge_and_tiny_weights,
       {},
       {},
       {em_edit("MAX_V(s, (real_v)(1e-30f))", "MAX_V(s, (real_v)(1e-3f))")}},
  };
}

}  // namespace

std::vector<NumericalCase> em_cases() {
  std::vector<NumericalCase> cases = sharp_cases();
  for (auto* part : {wide_cases, input_cases})
    for (NumericalCase& c : part()) cases.push_back(std::move(c));
  return cases;
}

}  // namespace multum
