// SPDX-License-Identifier: Apache-2.0
// Tests spherical harmonics (kernels/sh_project.cl, sh_shade.cl) up to order 20, at the poles, and for vectors that are
// not unit vectors.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "host/bakes/accuracy/highlight.h"
#include "host/formats/asset/averages/spherical_harmonics.h"
#include "host/foundation/base/mean_cosine.h"
#include "host/foundation/base/split_mix.h"
#include "host/lab/reference/spherical_harmonics.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"
#include "host/lab/selftest/sh_launch.h"
#include "kernels/shared/filtered_sh.h"
#include "kernels/shared/mip_box.h"

namespace multum {

std::vector<std::vector<float>> project_sh(Device& device, int order, const std::vector<glm::vec3>& normals,
                                           bool shortened) {
  const auto count = static_cast<std::size_t>(sh_coefficient_count(order));
  std::vector<DeviceBuffer> planes;
  std::vector<std::vector<float>> values(3);
  for (int c = 0; c < 3; ++c) {
    for (const glm::vec3& n : normals) values[static_cast<std::size_t>(c)].push_back(n[c]);
    planes.push_back(
        device.wrap_buffer(values[static_cast<std::size_t>(c)].data(), normals.size() * sizeof(float), "normals"));
  }
  const std::vector<ShStep> steps = sh_recurrence(order);
  const DeviceBuffer step_buffer = device.wrap_buffer(steps.data(), steps.size() * sizeof(ShStep), "recurrence");
  std::vector<float> nodes(count * normals.size(), NAN);
  DeviceBuffer out = device.make_buffer(nodes.size() * sizeof(float), "nodes");
  device.write(out, nodes.data(), out.byte_count());
  MultumBoxBand band{};
  band.map_width = band.row_length = static_cast<int>(normals.size());
  band.map_height = band.row_count = 1;
  band.plane_count = static_cast<int>(count);
  device.kernel("sh_project", "sh_project", {1, 1, false, false, order})
      .launch({normals.size()}, planes[0], planes[1], planes[2], step_buffer, out, band, shortened ? 1 : 0);
  device.read(out, nodes.data(), out.byte_count());
  std::vector<std::vector<float>> coefficients(normals.size(), std::vector<float>(count));
  for (std::size_t n = 0; n < normals.size(); ++n)
    for (std::size_t i = 0; i < count; ++i) coefficients[n][i] = nodes[i * normals.size() + n];
  return coefficients;
}

std::vector<double> shade_sh(Device& device, int order, const std::vector<float>& coefficients, float share, float s,
                             const std::vector<glm::vec3>& directions) {
  const bool lambert = s == 0.0f;
  std::vector<glm::vec4> vectors;
  for (const glm::vec3& w : directions) vectors.emplace_back(w, 0.0f);
  MultumFilteredSh point{};
  point.share = share;
  const std::vector<ShStep> steps = sh_recurrence(order);
  const ZonalCoefficients exact = lambert ? zonal_lambert(order) : zonal_blinn_phong(order, static_cast<double>(s));
  const std::vector<float> zonal(exact.begin(), exact.end());
  const auto wrap = [&](const auto& values) {
    return device.wrap_buffer(values.data(), values.size() * sizeof(values[0]), "shading");
  };
  const MultumHighlight shaded = shaded_highlight(static_cast<double>(s));
  const DeviceBuffer highlight = device.wrap_buffer(&shaded, sizeof(shaded), "highlight");
  const DeviceBuffer points = device.wrap_buffer(&point, sizeof(point), "point");
  const DeviceBuffer g = wrap(coefficients), step_buffer = wrap(steps), a = wrap(zonal), w = wrap(vectors);
  std::vector<float> values(directions.size(), NAN);
  DeviceBuffer out = device.make_buffer(values.size() * sizeof(float), "values");
  device.write(out, values.data(), out.byte_count());
  const int count = static_cast<int>(directions.size());
  device.kernel("sh_shade", "sh_shade", {1, 1, false, false, order})
      .launch({1}, g, points, step_buffer, a, w, w, highlight, out, 1, lambert ? 0 : count, lambert ? count : 0,
              lambert ? 0 : 1);
  device.read(out, values.data(), out.byte_count());
  return {values.begin(), values.end()};
}

namespace {

// Returns the square root of the sum of Y_lm^2 over all m, which bounds |Y_lm| for every m. Errors of coefficients are
// relative to this bound.
double bound_of_band(int l) { return std::sqrt((2.0 * l + 1.0) / (4.0 * std::numbers::pi)); }

glm::vec3 random_direction(SplitMix64& random) {
  const double z = 2.0 * random.uniform() - 1.0, phi = 2.0 * std::numbers::pi * random.uniform(),
               side = std::sqrt(1.0 - z * z);
  return glm::vec3(side * std::cos(phi), side * std::sin(phi), z);
}

// Compares each coefficient of each normal with its definition, evaluated at `meant`. The normals can have any length.
void add_basis(Device& device, int order, const std::vector<glm::vec3>& normals, const std::vector<glm::dvec3>& meant,
               WorstError& worst) {
  const std::vector<std::vector<float>> found = project_sh(device, order, normals);
  for (std::size_t n = 0; n < normals.size(); ++n)
    for (int l = 1; l <= order; ++l)
      for (int m = -l; m <= l; ++m)
        worst.add(
            static_cast<double>(found[n][static_cast<std::size_t>(sh_coefficient(l, m))]),
            reference::sh_basis(l, m, meant[n]), bound_of_band(l),
            fmt::format("normal ({:.3g}, {:.3g}, {:.3g}), l {}, m {}", normals[n].x, normals[n].y, normals[n].z, l, m));
}

std::vector<glm::dvec3> as_double(const std::vector<glm::vec3>& normals) {
  std::vector<glm::dvec3> result;
  for (const glm::vec3& n : normals) result.emplace_back(n);
  return result;
}

std::vector<glm::vec3> all_directions() {
  SplitMix64 random(20);
  std::vector<glm::vec3> normals;
  for (int i = 0; i < 300; ++i) normals.push_back(random_direction(random));
  return normals;
}

void basis_to_order_20(Device& device, WorstError& worst) {
  const std::vector<glm::vec3> normals = all_directions();
  for (const int order : {1, 4, 8, 20}) add_basis(device, order, normals, as_double(normals), worst);
}

constexpr double kMeanCosines[] = {0.5, 0.51, 0.6, 0.8, 0.95, 0.99, 0.9999, 0.999999};

// Tests normals that were shortened to represent the width of a BRDF. The widths range from the widest lobe to the
// sharpest lobe that is not a single direction.
void rough_normals(Device& device, WorstError& worst) {
  constexpr int kOrder = 20;
  SplitMix64 random(21);
  std::vector<glm::vec3> normals;
  for (const double c : kMeanCosines) normals.push_back(static_cast<float>(c) * random_direction(random));
  const std::vector<std::vector<float>> found = project_sh(device, kOrder, normals, true);
  for (std::size_t n = 0; n < normals.size(); ++n) {
    const glm::dvec3 exact(normals[n]);
    const ZonalCoefficients zonal = zonal_vmf(kOrder, glm::length(exact));
    for (int l = 1; l <= kOrder; ++l)
      for (int m = -l; m <= l; ++m)
        worst.add(static_cast<double>(found[n][static_cast<std::size_t>(sh_coefficient(l, m))]),
                  zonal[static_cast<std::size_t>(l)] * reference::sh_basis(l, m, exact), bound_of_band(l),
                  fmt::format("mean cosine {:.6g}, l {}, m {}", glm::length(exact), l, m));
  }
}

// Computes `a_(l+1) = a_(l-1) - (2l + 1) / kappa a_l` upwards from `a_0 = 1` and `a_1 = c` in float.
void upward_zonal(WorstError& worst) {
  for (const double c : kMeanCosines) {
    const ZonalCoefficients exact = zonal_vmf(20, c);
    const auto kappa = static_cast<float>(kappa_of_mean_cosine(c, HUGE_VAL));
    float before = 1.0f, a = static_cast<float>(c);
    for (int l = 1; l < 20; ++l) {
      const float next = before - static_cast<float>(2 * l + 1) / kappa * a;
      before = a;
      a = next;
      worst.add(static_cast<double>(a), exact[static_cast<std::size_t>(l) + 1], 1.0,
                fmt::format("mean cosine {:.6g}, l {}", c, l + 1));
    }
  }
}

// Computes P_lm by the textbook recurrence and multiplies by `sqrt((2l+1)/(4 pi) (l-m)!/(l+m)!)`, all in float.
void textbook_basis(WorstError& worst) {
  for (const glm::vec3& n : all_directions())
    for (int m = 0; m <= 20; ++m) {
      float before = 0.0f, p = 1.0f;
      const float side = std::sqrt(1.0f - n.z * n.z);
      for (int k = 1; k <= m; ++k) p *= static_cast<float>(2 * k - 1) * side;
      for (int l = m; l <= 20; ++l) {
        if (l > m) {
          const float next = (static_cast<float>(2 * l - 1) * n.z * p - static_cast<float>(l + m - 1) * before) /
                             static_cast<float>(l - m);
          before = p;
          p = next;
        }
        float up = 1.0f, down = 1.0f;
        for (int k = 2; k <= l - m; ++k) up *= static_cast<float>(k);
        for (int k = 2; k <= l + m; ++k) down *= static_cast<float>(k);
        const float y =
            std::sqrt(2.0f * static_cast<float>(2 * l + 1) / static_cast<float>(4.0 * std::numbers::pi) * up / down) *
            p * std::cos(static_cast<float>(m) * std::atan2(n.y, n.x));
        if (m > 0) worst.add(static_cast<double>(y), reference::sh_basis(l, m, glm::dvec3(n)), bound_of_band(l), "");
      }
    }
}

std::vector<glm::vec3> polar_directions() {
  std::vector<glm::vec3> normals;
  for (const float z : {1.0f, -1.0f})
    for (const float side : {0.0f, -0.0f, 1e-45f, 1e-30f, 1e-12f, 1e-6f, 1e-3f}) {
      normals.emplace_back(side, 0.0f, z);
      normals.emplace_back(-side, side, z);
    }
  return normals;
}

void poles(Device& device, WorstError& worst) {
  const std::vector<glm::vec3> normals = polar_directions();
  add_basis(device, 20, normals, as_double(normals), worst);
}

// Computes `cos phi = x / sin theta`.
void divided_by_sine(WorstError& worst) {
  for (const glm::vec3& n : polar_directions()) {
    const float side = std::sqrt(std::max(0.0f, 1.0f - n.z * n.z)), cosine = n.x / side;
    worst.add(static_cast<double>(std::sqrt(3.0f / static_cast<float>(4.0 * std::numbers::pi)) * side * cosine),
              reference::sh_basis(1, 1, glm::dvec3(n)), bound_of_band(1), "");
  }
}

void not_unit(Device& device, WorstError& worst) {
  std::vector<glm::vec3> normals;
  const std::vector<glm::vec3> directions = all_directions();
  for (const float length : {1e-38f, 1e-30f, 1e-3f, 0.5f, 1.01f, 3.0f, 1e10f, 1e37f})
    for (std::size_t i = 0; i < 8; ++i) normals.push_back(length * directions[i]);
  add_basis(device, 20, normals, as_double(normals), worst);
}

void no_direction(Device& device, WorstError& worst) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  const std::vector<glm::vec3> normals = {{0.0f, 0.0f, 0.0f},  {-0.0f, 0.0f, -0.0f}, {kNan, 0.0f, 1.0f},
                                          {0.0f, kNan, 0.5f},  {0.1f, 0.2f, kNan},   {kInf, 0.0f, 0.0f},
                                          {0.0f, -kInf, 1.0f}, {kInf, -kInf, kInf},  {kNan, kNan, kNan}};
  add_basis(device, 8, normals, std::vector<glm::dvec3>(normals.size(), glm::dvec3(0.0, 0.0, 1.0)), worst);
}

// Tests a single tilt at order 4, for which the series oscillates. Negative values of the series must not become
// negative light.
void ringing(Device& device, WorstError& worst) {
  const std::vector<glm::vec3> directions = all_directions();
  for (const int order : {2, 4, 8, 20}) {
    const std::vector<float> g = project_sh(device, order, {glm::vec3(tilted(30.0))}).front();
    for (const float s : {0.0f, 20.0f, 100.0f, 1e5f})
      for (const double value : shade_sh(device, order, g, 1.0f, s, directions))
        worst.add(std::max(-value, 0.0) + 0.0 * value, fmt::format("order {}, s {}", order, s));
  }
}

// Tests two opposite tilts with equal shares. The mean direction is almost undefined, but both sides must have a
// highlight.
void opposite_tilts(Device& device, WorstError& worst) {
  const std::vector<glm::vec3> directions = all_directions();
  for (const int order : {2, 8, 20})
    for (const double angle : {1e-3, 30.0, 89.9, 90.0}) {
      const std::vector<glm::vec3> tilts = {glm::vec3(tilted(angle)), glm::vec3(tilted(angle, std::numbers::pi))};
      const std::vector<std::vector<float>> both = project_sh(device, order, tilts);
      std::vector<float> mean(both[0].size());
      std::vector<double> exact(both[0].size());
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = 0.5f * (both[0][i] + both[1][i]);
      const std::vector<double> a = reference::sh_basis_to(order, glm::dvec3(tilts[0])),
                                b = reference::sh_basis_to(order, glm::dvec3(tilts[1]));
      for (std::size_t i = 0; i < exact.size(); ++i) exact[i] = 0.5 * (a[i] + b[i]);
      for (const float s : {0.0f, 12.0f, 500.0f}) {
        const ZonalCoefficients zonal =
            s == 0.0f ? zonal_lambert(order) : zonal_blinn_phong(order, static_cast<double>(s));
        const double peak = reference::shade_sh(a, 1.0, zonal, glm::dvec3(tilts[0]));
        const std::vector<double> found = shade_sh(device, order, mean, 1.0f, s, directions);
        for (std::size_t d = 0; d < directions.size(); ++d)
          worst.add(found[d], std::max(0.0, reference::shade_sh(exact, 1.0, zonal, glm::dvec3(directions[d]))), peak,
                    fmt::format("order {}, {} degrees, s {}", order, angle, s));
      }
    }
}

SourceEdit direction_edit(const std::string& text, const std::string& replacement) {
  return {"sh_project", text, replacement};
}

}  // namespace

std::vector<NumericalCase> sh_cases() {
  const std::string unit = "of the largest value in the band";
  const std::string reason =
      "near a pole, the rounding error of 1 - z^2 is multiplied by the square of the order, and the recurrence has 20 "
      "steps";
  return {
      {{"harmonics-to-order-20", "sh_project",
        "the factorials and Legendre functions of the direct formula overflow, because 40! exceeds the range of a "
        "float",
        "each step of the recurrence is normalised, with constants computed in double precision", 1e-5, unit, reason},
       basis_to_order_20,
       {},
       textbook_basis},
      {{"harmonics-at-the-poles", "sh_project", "computing the azimuth with x / sin theta divides 0 by 0 at the poles",
        "the kernel uses the powers (x + iy)^m, which contain the factor sin^m theta, so it does not divide", 1e-5,
        unit, reason},
       poles,
       {},
       divided_by_sine},
      {{"harmonics-of-vectors-not-unit", "sh_project",
        "the power (x + iy)^20 overflows for long vectors, and the squares of components near 1e-30 underflow to 0",
        "vectors are scaled by their largest component and then normalised", 1e-5, unit, reason},
       not_unit,
       {direction_edit("const float3 scaled = (float3)(x / largest, y / largest, z / largest);",
                       "return (float3)(x, y, z);\n  const float3 scaled = (float3)(x, y, z);")}},
      {{"harmonics-of-no-direction", "sh_project", "a normal of length 0 makes every coarser texel NaN",
        "normals of length 0 are treated as pointing up", 1e-6, unit,
        "the direction is a pole, where z is exactly 1 and rounding errors are small"},
       no_direction,
       {direction_edit("if (!(largest > 0.0f && largest < INFINITY) || isnan(x + y + z))", "if (0)")}},
      {{"harmonics-of-rough-normals", "sh_project",
        "the upward recurrence for the zonal coefficients of a lobe loses digits by cancellation",
        "ratios of coefficients are computed downwards, starting with the asymptotic ratio at a much higher order",
        5e-5, unit, "kappa, which is computed from the mean cosine, has an error of at most 3.3e-5"},
       rough_normals,
       {},
       upward_zonal},
      {{"harmonics-ring-below-0", "sh_shade",
        "a truncated series oscillates, and negative light darkens its surroundings", "the result is clamped at 0",
        kNothingWrong, "deviation below 0", "no result may be negative"},
       ringing,
       {{"sh_shade", "return max(sum, 0.0f);", "return sum;"}}},
      {{"harmonics-of-opposite-tilts", "sh_shade",
        "highlights vanish if vectors are not normalised or the mean direction has length 0",
        "the series needs no guard, because it represents both tilts", 2e-5, "of the peak of one tilt",
        "the basis functions have rounding errors in the coefficients and in the evaluation, which the coefficients of "
        "the lobe weight"},
       opposite_tilts,
       {},
       {},
       {{"sh_shade", "const float rotated = fma(c, w.x, -s * w.y);", "const float rotated = c * w.x;"}}},
  };
}

}  // namespace multum
