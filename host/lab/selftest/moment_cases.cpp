// SPDX-License-Identifier: Apache-2.0
// Tests moments of slopes and mean normals (kernels/moments.cl) and their shading by Toksvig's rule and LEAN
// (moment_shade.cl, device/moment_shading.clh). The inputs contain normals at the horizon, variances that are
// differences of nearly equal numbers, and divisors that are 0.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/lab/reference/moments.h"
#include "host/lab/reference/shading.h"
#include "host/lab/selftest/buffers.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"
#include "host/lab/selftest/moment_launch.h"
#include "host/lab/selftest/shade_launch.h"
#include "kernels/shared/mip_box.h"
#include "kernels/shared/moments.h"

namespace multum {

std::vector<std::vector<float>> finest_moments(Device& device, const std::vector<glm::vec3>& normals, bool shortened) {
  std::vector<float> planes[3];
  for (const glm::vec3& n : normals)
    for (int k = 0; k < 3; ++k) planes[k].push_back(n[k]);
  MultumBoxBand band{};
  band.map_width = band.row_length = static_cast<int>(normals.size());
  band.map_height = band.row_count = 1;
  band.plane_count = MULTUM_MOMENT_PLANES;
  const DeviceBuffer nodes =
      uploaded(device, std::vector<float>(normals.size() * MULTUM_MOMENT_PLANES, kPoison), "nodes");
  device.kernel("moments", "moment_finest", {1, 1, false})
      .launch({normals.size()}, uploaded(device, planes[0], "x"), uploaded(device, planes[1], "y"),
              uploaded(device, planes[2], "z"), nodes, band, kSlopeZMin, shortened ? 1 : 0);
  const std::vector<float> found = downloaded<float>(device, nodes);
  std::vector<std::vector<float>> moments(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i)
    for (std::size_t p = 0; p < MULTUM_MOMENT_PLANES; ++p) moments[i].push_back(found[p * normals.size() + i]);
  return moments;
}

std::vector<double> shade_moments(Device& device, const MultumFilteredMoments& moments, int shading, double s,
                                  const std::vector<glm::vec4>& half_vectors) {
  const int count = static_cast<int>(half_vectors.size());
  const DeviceBuffer out = uploaded(device, std::vector<float>(half_vectors.size() + 1, kPoison), "values");
  const DeviceBuffer vectors = uploaded(device, half_vectors, "half vectors");
  device.kernel("moment_shade", "moment_shade", {1, 1, false})
      .launch({1}, uploaded(device, std::vector{moments}, "moments"), vectors, vectors,
              uploaded(device, std::vector{static_cast<float>(s)}, "exponent"), out, 1, count, 1, 1, shading);
  const std::vector<float> values = downloaded<float>(device, out);
  return {values.begin(), values.end()};
}

namespace {

double wide(float value) { return static_cast<double>(value); }

// Adds the relative errors of values above 1 and the absolute errors of values below 1.
void add_finest(Device& device, const std::vector<glm::vec3>& normals, bool shortened, WorstError& worst) {
  const std::vector<std::vector<float>> found = finest_moments(device, normals, shortened);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const glm::dvec3 n(normals[i]);
    const double length = shortened ? glm::length(n) : 1.0, variance = std::max(1.0 - length, 0.0);
    const double z = std::max(n.z, wide(kSlopeZMin) * std::max(length, 1e-6)), s = -n.x / z, t = -n.y / z;
    const double expected[] = {s, t, s * s + variance, t * t + variance, s * t, n.x, n.y, n.z};
    for (std::size_t p = 0; p < MULTUM_MOMENT_PLANES; ++p)
      worst.add(wide(found[i][p]), expected[p], std::max(1.0, std::abs(expected[p])),
                fmt::format("normal ({:.3g}, {:.3g}, {:.3g}), plane {}", n.x, n.y, n.z, p));
  }
}

void slopes_at_the_horizon(Device& device, WorstError& worst) {
  std::vector<glm::vec3> normals;
  for (const float z : {0.0f, -0.0f, 1e-45f, 1e-30f, 0.0499999f, 0.05f, 0.0500001f, 0.7f, 1.0f, -1e-6f, -1.0f})
    for (const double azimuth : {0.0, 0.3, 2.0, 4.0}) {
      const double side = std::sqrt(std::max(0.0, 1.0 - wide(z) * wide(z)));
      normals.emplace_back(side * std::cos(azimuth), -side * std::sin(azimuth), z);
    }
  add_finest(device, normals, false, worst);
  add_finest(device, normals, true, worst);
}

// Tests normals with lengths from 0 to above 1.
void shortened_normals(Device& device, WorstError& worst) {
  std::vector<glm::vec3> normals = {{0.0f, 0.0f, 0.0f}, {-0.0f, 0.0f, -0.0f}, {1e-40f, 0.0f, -1e-40f}};
  for (const float length : {1e-30f, 1e-12f, 1e-3f, 0.5f, 1.0f - 0x1p-20f, 1.0f, 1.0f + 0x1p-20f, 1.25f})
    for (const double degrees : {0.0, 45.0, 89.0, 90.0, 135.0}) normals.push_back(length * glm::vec3(tilted(degrees)));
  add_finest(device, normals, true, worst);
}

// Returns moments of slopes with mean (s, t), the given second moments and share 1.
MultumFilteredMoments of_slopes(float s, float t, float ss, float tt, float st) {
  MultumFilteredMoments m{};
  m.normal_z = m.share = 1.0f;
  m.s = s, m.t = t, m.ss = ss, m.tt = tt, m.st = st;
  return m;
}

// Returns a half vector with slope (s, t), rounded to the precision of the kernel's input.
glm::vec4 half_at(double s, double t) { return {glm::vec3(glm::normalize(glm::dvec3(-s, -t, 1.0))), 0.0f}; }

double exact_lean(const MultumFilteredMoments& m, double s, const glm::vec4& h) {
  reference::TexelMoments wide_moments;
  wide_moments.s = wide(m.s), wide_moments.t = wide(m.t), wide_moments.ss = wide(m.ss), wide_moments.tt = wide(m.tt),
  wide_moments.st = wide(m.st);
  return reference::lean(wide_moments, glm::dvec3(h), s, false);
}

// Tests second moments that are smaller than the square of the mean because of rounding, for slopes up to the largest
// slope, 20. Only the variance of the BRDF remains, so no value may exceed the peak of the BRDF.
void variance_below_0(Device& device, WorstError& worst) {
  for (const float mean : {0.0f, 0.5f, 3.0f, 20.0f})
    for (const float missing : {0.0f, 1e-7f, 1e-5f, 0.1f})
      for (const double s : {1.0, 100.0, 1e5}) {
        const float square = mean * mean * (1.0f - missing) - (mean == 0.0f ? missing : 0.0f);
        const MultumFilteredMoments m = of_slopes(mean, -mean, square, square, -square);
        const std::vector<glm::vec4> h = {half_at(wide(mean), -wide(mean)), half_at(0.0, 0.0)};
        const double peak = s / (2.0 * M_PI);
        const std::vector<double> values = shade_moments(device, m, MULTUM_SHADE_LEAN, s, h);
        for (std::size_t i = 0; i < h.size(); ++i) {
          const std::string input = fmt::format("mean slope {}, {} missing, s {}, vector {}", mean, missing, s, i);
          worst.add((std::max(values[i] - peak, 0.0) + std::max(-values[i], 0.0)) / peak + 0.0 * values[i], input);
        }
      }
}

// Tests slopes along one line of the plane. The determinant of Sigma is 0, and the variance across the line is only the
// variance of the BRDF, 1/s.
void slopes_along_a_line(Device& device, WorstError& worst) {
  for (const float variance : {4.0f, 64.0f, 256.0f})
    for (const float sign : {1.0f, -1.0f})
      for (const double s : {10.0, 1e3, 1e5}) {
        const MultumFilteredMoments m = of_slopes(0.0f, 0.0f, variance, variance, sign * variance);
        const std::vector<glm::vec4> h = {half_at(0.0, 0.0)};
        const double expected = exact_lean(m, s, h[0]);
        worst.add(shade_moments(device, m, MULTUM_SHADE_LEAN, s, h)[0], expected, expected,
                  fmt::format("variance {}, correlation {}, s {}", variance, sign, s));
      }
}

// Tests steep and nearly equal slopes under a sharp highlight, at one highlight width from the peak. The case compares
// the rounding error of E[s^2] - E[s]^2 in single precision with the variance 1/s.
void steep_and_sharp(Device& device, WorstError& worst) {
  for (const double slope : {0.1, 1.0, 5.0, 20.0})
    for (const double variance : {0.0, 1e-6, 1e-4})
      for (const double s : {100.0, 1e3, 1e4, 1e5}) {
        reference::TexelMoments exact;
        exact.s = slope, exact.t = -slope, exact.st = -slope * slope;
        exact.ss = exact.tt = slope * slope + variance;
        const auto narrow = [](double x) { return static_cast<float>(x); };
        const MultumFilteredMoments m =
            of_slopes(narrow(exact.s), narrow(exact.t), narrow(exact.ss), narrow(exact.tt), narrow(exact.st));
        const double off = std::sqrt(variance + 1.0 / s), peak = s / (2.0 * M_PI);
        const double lost = 0x1p-22 * (s * slope * slope + std::sqrt(s) * (1.0 + slope));
        const std::vector<glm::vec4> h = {half_at(slope, -slope), half_at(slope + off, -slope)};
        const std::vector<double> values = shade_moments(device, m, MULTUM_SHADE_LEAN, s, h);
        for (std::size_t i = 0; i < h.size(); ++i)
          worst.add(values[i], reference::lean(exact, glm::dvec3(h[i]), s, false), peak * (1e-6 + lost),
                    fmt::format("slope {}, variance {}, s {}, vector {}", slope, variance, s, i));
      }
}

// Tests half vectors at and below the horizon, where the slope and the Jacobian are unbounded.
void half_vectors_at_the_horizon(Device& device, WorstError& worst) {
  std::vector<glm::vec4> h;
  for (const float z : {1.1e-4f, 1e-4f, 1e-20f, 1e-40f, 0.0f, -0.0f, -1e-3f, -1.0f})
    h.emplace_back(std::sqrt(1.0f - z * z), 0.0f, z, 0.0f);
  for (const double s : {1.0, 100.0, 1e5})
    for (const int shading : {MULTUM_SHADE_LEAN, MULTUM_SHADE_LEAN_JACOBIAN}) {
      const std::vector<double> values =
          shade_moments(device, of_slopes(-20.0f, 0.0f, 400.0f, 0.0f, 0.0f), shading, s, h);
      for (std::size_t i = 0; i < h.size(); ++i)
        worst.add(h[i].z <= 1e-4f ? values[i] : 0.0 * values[i], fmt::format("z {}, s {}", h[i].z, s));
    }
}

// Tests mean normals of every length, including 0 and lengths above 1.
void toksvig_of_every_length(Device& device, WorstError& worst) {
  const glm::dvec3 up(0.0, 0.0, 1.0);
  for (const float length : {0.0f, 1e-40f, 1e-20f, 1e-6f, 0.5f, 1.0f - 0x1p-20f, 1.0f, 1.0f + 0x1p-20f, 1.001f})
    for (const double s : {1.0, 20.0, 1000.0, 1e5}) {
      MultumFilteredMoments m{};
      m.normal_z = length;
      m.share = 1.0f;
      const double size = std::min(wide(length), 1.0), exponent = s * size / (size + s * (1.0 - size));
      std::vector<glm::vec4> h;
      for (int i = 0; i < 20; ++i)
        h.emplace_back(glm::vec3(tilted(89.0 * (i + 0.5) / 20.0 / std::sqrt(exponent + 1.0))), 0.0f);
      const std::vector<double> values = shade_moments(device, m, MULTUM_SHADE_TOKSVIG, s, h);
      for (std::size_t i = 0; i < h.size(); ++i)
        worst.add(values[i], reference::blinn_phong(exponent, angle_seen(up, h[i])), (exponent + 1.0) / (2.0 * M_PI),
                  fmt::format("length {}, s {}, vector {}", length, s, i));
      worst.add(values.back(), wide(length) * wide(h[0].z), 1.0, "Lambert");
    }
}

// Tests stored levels whose share of the result is 0, or is nearly 0 because of rounding. In this case, the result is
// the value of the normal map.
void no_share(Device& device, WorstError& worst) {
  for (const float share : {0.0f, 1e-45f, 1e-30f, 1e-8f})
    for (const int shading : {MULTUM_SHADE_TOKSVIG, MULTUM_SHADE_LEAN, MULTUM_SHADE_LEAN_JACOBIAN}) {
      MultumFilteredMoments m{};
      m.share = m.normal_z = share;
      m.s = m.ss = share;
      m.map_z = m.map_share = 1.0f;
      const std::vector<glm::vec4> h = {half_at(0.1, 0.0)};
      const double expected = reference::blinn_phong(100.0, angle_seen({0.0, 0.0, 1.0}, h[0]));
      worst.add(shade_moments(device, m, shading, 100.0, h)[0], expected, expected,
                fmt::format("share {}, shading {}", share, shading));
    }
}

SourceEdit moment_shade_edit(const std::string& text, const std::string& replacement) {
  return {"moment_shade", text, replacement};
}

std::vector<NumericalCase> finest_cases() {
  const char* const kUnit = "relative error of values above 1 (or absolute error of values below 1)";
  return {
      {{"slopes-at-the-horizon", "moment_finest",
        "the slope at the horizon divides by zero, so the mean slope is infinite",
        "a z below 0.05 is replaced by 0.05, so slopes are at most 20", 5e-7, kUnit,
        "only three operations are rounded: a division, a square and a sum"},
       slopes_at_the_horizon,
       {{"moments", "z > z_min ? z : z_min", "z"}}},
      {{"shortened-normals-to-0", "moment_finest", "the slope of a normal of length 0 is 0 divided by 0",
        "the kernel divides z by a length of at least 1e-6, and replaces negative variances by 0", 5e-7, kUnit,
        "only four operations are rounded: a square root, a division, a square and a sum"},
       shortened_normals,
       {{"moments", "slope_z_min * MAX_V(length, 1e-6f)", "slope_z_min * length"}}},
  };
}

}  // namespace

std::vector<NumericalCase> moment_cases() {
  std::vector<NumericalCase> cases = finest_cases();
  const auto add = [&](const char* name, const char* without, const char* guard, double bound, const char* unit,
                       const char* reason, void (*run)(Device&, WorstError&), const std::vector<SourceEdit>& edits,
                       const std::vector<SourceEdit>& mutation = {}) {
    cases.push_back({{name, "moment_shade", without, guard, bound, unit, reason}, run, edits, {}, mutation});
  };
  add("slope-variance-below-0",
      "rounding makes the mean squared slope smaller than the square of the mean slope, and the negative determinant "
      "has no square root",
      "variances are at least 0", 2e-6, "amount of light above the peak or below 0, relative to the peak,",
      "only three operations are rounded: a square root, a division and an exponential", variance_below_0,
      {moment_shade_edit("max(ss - s_mean * s_mean, 0.0f)", "ss - s_mean * s_mean"),
       moment_shade_edit("max(tt - t_mean * t_mean, 0.0f)", "tt - t_mean * t_mean")});
  add("slopes-along-a-line",
      "if the determinant of Sigma + I/s (Sigma is the covariance) is computed as a difference, it has no correct "
      "digit at exponent s = 1e5",
      "the determinant of Sigma is kept at or above 0, and the positive term 1/s (1/s + trace) is added to it", 2e-6,
      "relative error", "only a square root, a division and four products are rounded", slopes_along_a_line,
      {moment_shade_edit(
          "base * (base + variance_s + variance_t) + max(variance_s * variance_t - covariance * covariance, "
          "0.0f)",
          "(base + variance_s) * (base + variance_t) - covariance * covariance")});
  add("steep-slopes-under-sharp-highlights",
      "16-bit floats near 400 have steps of 0.25, but a highlight with exponent s = 1e5 needs moments in steps of 1e-5",
      "moments are stored in 32 bits, so rounding widens a highlight at slope b by at most 2^-22 s b^2 times its width",
      1.0, "times the allowed error, which is 2^-22 (s b^2 + sqrt(s) (1 + b)) + 1e-6 of the peak at slope b",
      "the mean squared slope and the square of the mean slope each have a rounding error of up to 2^-24 b^2",
      steep_and_sharp, {},
      {moment_shade_edit("max(ss - s_mean * s_mean, 0.0f)", "max(rint(ss * 4.0f) * 0.25f - s_mean * s_mean, 0.0f)")});
  add("half-vectors-at-the-horizon",
      "a half vector at the horizon has an infinite slope, so the distance between slopes is infinity minus infinity",
      "the result is 0 for half vectors with z up to 1e-4", kNothingWrong, "deviation from 0, including NaN",
      "the result must be exact", half_vectors_at_the_horizon,
      {moment_shade_edit("if (half_vector.z <= 1e-4f) return 0.0f;", "")});
  add("mean-normals-of-every-length",
      "a mean normal longer than 1 gives a gloss above 1 or below 0, and normalising a mean of length 0 divides 0 by 0",
      "the length is 1 minus a spread between 0 and 1, and a mean of length 0 gets an arbitrary direction", 1e-5,
      "of the peak",
      "the mean direction mu and the half vector h have rounding errors of up to 6e-8, which the exponent multiplies",
      toksvig_of_every_length,
      {moment_shade_edit("clamp((lobe.w - length) / max(lobe.w, AMPLITUDE_SHADED_MIN), 0.0f, 1.0f)",
                         "((lobe.w - length) / max(lobe.w, AMPLITUDE_SHADED_MIN))")});
  add("moments-of-no-share", "moments with share 0 reflect as much light as moments with share 1",
      "the kernel does not divide by shares up to 1e-6, and multiplies the result by the share", 1e-5, "relative error",
      "only the share and the constant factor 16/(2 pi) are rounded", no_share,
      {moment_shade_edit(": m.share * shade_lean(", ": shade_lean(")});
  return cases;
}

}  // namespace multum
