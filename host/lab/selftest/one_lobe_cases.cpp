// SPDX-License-Identifier: Apache-2.0
// Tests the fit of one GGX lobe to a texel (kernels/one_lobe.cl). The inputs contain lobes of width 0, normals of
// length 0, facets behind the mean normal, and texels without facets.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <glm/geometric.hpp>

#include "host/lab/selftest/buffers.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/one_lobe_launch.h"
#include "kernels/shared/mip_box.h"
#include "kernels/shared/one_lobe.h"

namespace multum {
namespace {

constexpr int kStride = MULTUM_ONE_LOBE_BLOCK;  // distance between the planes of a texel

// Returns the averages of alpha^2 and of the planes that one_lobe_finest computes from the map. All texels have the
// same weight.
std::vector<float> launched_averages(Device& device, const reference::OneLobeTexel& texel) {
  const NormalMap& map = *texel.map;
  const std::size_t texels = map.x.size();
  MultumBoxBand band{};
  band.map_width = band.row_length = map.width;
  band.map_height = band.row_count = map.height;
  band.plane_count = MULTUM_ONE_LOBE_PLANES;
  const DeviceBuffer nodes =
      uploaded(device, std::vector<float>(texels * MULTUM_ONE_LOBE_PLANES, kPoison), "nodes of a lobe");
  device.kernel("one_lobe", "one_lobe_finest", {1, 1, false})
      .launch({texels}, uploaded(device, map.x, "x"), uploaded(device, map.y, "y"), uploaded(device, map.z, "z"), nodes,
              band);
  const std::vector<float> planes = downloaded<float>(device, nodes);
  std::vector<float> averages(MULTUM_ONE_LOBE_AVERAGES * kStride, 0.0f);
  for (std::size_t p = 0; p < MULTUM_ONE_LOBE_PLANES; ++p) {
    double sum = 0.0;
    for (std::size_t i = 0; i < texels; ++i) sum += static_cast<double>(planes[p * texels + i]);
    averages[p * kStride] = static_cast<float>(sum / static_cast<double>(texels));
  }
  averages[MULTUM_ONE_LOBE_BASE * kStride] = static_cast<float>(texel.base_squared[0]);
  return averages;
}

}  // namespace

reference::OneLobe launch_one_lobe(Device& device, const reference::OneLobeTexel& texel,
                                   const std::vector<glm::vec2>& facets, int grid, int lanes) {
  const NormalMap& map = *texel.map;
  MultumOneLobePiece piece{};
  piece.map_width = map.width;
  piece.width = piece.row_count = 1;
  piece.grid = grid;
  piece.stride = kStride;
  piece.iteration_count = texel.iteration_count;
  piece.is_anisotropic = texel.is_anisotropic ? 1 : 0;
  piece.base_squared = static_cast<float>(texel.base_squared[0]);
  piece.alpha_min = static_cast<float>(texel.alpha_min);
  std::vector<int> rows, columns;
  for (int i = 0; i < grid; ++i) {
    rows.push_back((2 * i + 1) * map.height / (2 * grid));
    columns.push_back((2 * i + 1) * map.width / (2 * grid));
  }
  const auto samples = static_cast<std::size_t>(grid) * static_cast<std::size_t>(grid);
  const DeviceBuffer averages = uploaded(device, launched_averages(device, texel), "averages of a lobe");
  const DeviceBuffer slopes = uploaded(device, std::vector<float>(samples * 2 * kStride, kPoison), "slopes");
  device.kernel("one_lobe", "one_lobe_samples", {1, lanes, false})
      .launch({static_cast<std::size_t>(kStride / lanes * grid)}, uploaded(device, map.x, "x"),
              uploaded(device, map.y, "y"), uploaded(device, map.z, "z"),
              uploaded(device, std::vector<float>{0.0f}, "no roughness"), uploaded(device, rows, "rows"),
              uploaded(device, columns, "columns"), uploaded(device, facets, "facets"), averages, slopes, piece);
  const DeviceBuffer out =
      uploaded(device, std::vector<float>(MULTUM_ONE_LOBE_FITTED * kStride, kPoison), "a fitted lobe");
  device.kernel("one_lobe", "one_lobe_fit", {1, lanes, false})
      .launch({static_cast<std::size_t>(kStride / lanes)}, averages, slopes, out, piece);
  const std::vector<float> found = downloaded<float>(device, out);
  const auto value = [&](int plane) { return static_cast<double>(found[static_cast<std::size_t>(plane) * kStride]); };
  reference::OneLobe lobe;
  lobe.normal = {value(0), value(1), value(2)};
  lobe.alpha_wide = value(MULTUM_ONE_LOBE_ALPHA_WIDE);
  lobe.alpha_narrow = value(MULTUM_ONE_LOBE_ALPHA_NARROW);
  const glm::dvec3 x = glm::normalize(glm::dvec3(1.0, 0.0, 0.0) - lobe.normal.x * lobe.normal);
  lobe.axis = value(MULTUM_ONE_LOBE_AXIS) * x + value(MULTUM_ONE_LOBE_AXIS + 1) * glm::cross(lobe.normal, x);
  return lobe;
}

namespace {

constexpr int kGrid = 8;

// Returns facets along a spiral. Their distribution is GGX with alpha 1.
std::vector<glm::vec2> spiral_facets() {
  std::vector<glm::vec2> facets;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const double u = (i + 0.5) / (kGrid * kGrid), azimuth = 2.39996 * i;
    facets.emplace_back(std::sqrt(u / (1.0 - u)) * glm::dvec2(std::cos(azimuth), std::sin(azimuth)));
  }
  return facets;
}

NormalMap map_of(const std::function<glm::dvec3(int)>& normal_at) {
  NormalMap map;
  map.width = map.height = kGrid;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const glm::vec3 n(normal_at(i));
    map.x.push_back(n.x), map.y.push_back(n.y), map.z.push_back(n.z);
  }
  return map;
}

// Divides errors of alpha by 10, because files store the square root of alpha, and the kernel computes alpha from sums
// of squares.
void add_lobes(Device& device, const NormalMap& map, double alpha, const std::string& input, WorstError& worst) {
  const std::vector<glm::vec2> facets = spiral_facets();
  for (const bool is_anisotropic : {false, true})
    for (const int lanes : {1, 16}) {
      const reference::OneLobeTexel texel{&map, {alpha * alpha}, 1, 1, 0, 0, is_anisotropic, 5, 1e-3};
      const reference::OneLobe expected = reference::fit_one_lobe(texel, facets, kGrid),
                               found = launch_one_lobe(device, texel, facets, kGrid, lanes);
      const std::string where = fmt::format("{}, alpha {:g}, {}, {} lanes", input, alpha,
                                            is_anisotropic ? "anisotropic" : "isotropic", lanes);
      worst.add(glm::distance(found.normal, expected.normal), where);
      worst.add(0.1 * std::abs(found.alpha_narrow / expected.alpha_narrow - 1.0), where);
      worst.add(0.1 * std::abs(found.alpha_wide / expected.alpha_wide - 1.0), where);
      worst.add(0.1 * std::abs(glm::length(found.axis) - 1.0), where);
    }
}

glm::dvec3 tilted_by(double degrees, double azimuth) {
  const double t = degrees * M_PI / 180.0;
  return {std::sin(t) * std::cos(azimuth), std::sin(t) * std::sin(azimuth), std::cos(t)};
}

void mirrors(Device& device, WorstError& worst) {
  for (const double degrees : {0.0, 30.0, 89.0})
    for (const double alpha : {0.0, 1e-3, 0.03, 0.5, 1.0})
      add_lobes(device, map_of([&](int) { return tilted_by(degrees, 0.7); }), alpha,
                fmt::format("{:g} degrees", degrees), worst);
}

void facets_behind(Device& device, WorstError& worst) {
  for (const double degrees : {60.0, 80.0, 89.0})
    for (const double alpha : {0.1, 0.5, 1.0})
      add_lobes(device, map_of([&](int i) { return tilted_by(degrees, i % 2 == 0 ? 0.4 : 2.9); }), alpha,
                fmt::format("two tilts of {:g} degrees", degrees), worst);
}

void normals_of_nothing(Device& device, WorstError& worst) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const glm::dvec3& bad :
       {glm::dvec3(0.0), glm::dvec3(nan, 0.0, 1.0), glm::dvec3(0.0, inf, 0.0), glm::dvec3(1e-20)})
    add_lobes(device, map_of([&](int i) { return i % 5 == 0 ? bad : tilted_by(20.0, i); }), 0.1,
              fmt::format("a fifth is ({:g}, {:g}, {:g})", bad.x, bad.y, bad.z), worst);
}

void slopes_of_a_line(Device& device, WorstError& worst) {
  for (const double azimuth : {0.0, 0.785398163397, 1.570796326795, 2.5})
    for (const double alpha : {0.0, 1e-3})
      add_lobes(device, map_of([&](int i) { return tilted_by(0.5 * (i - 32), azimuth); }), alpha,
                fmt::format("tilts along {:g}", azimuth), worst);
}

void lobes_beyond_1(Device& device, WorstError& worst) {
  for (const double degrees : {50.0, 70.0, 85.0})
    add_lobes(device, map_of([&](int i) { return tilted_by(degrees, 0.1 * i * i); }), 1.0,
              fmt::format("all around at {:g} degrees", degrees), worst);
}

void no_mean_normal(Device& device, WorstError& worst) {
  for (const double alpha : {0.1, 0.7})
    add_lobes(device, map_of([&](int i) { return glm::dvec3(i % 2 == 0 ? 0.6 : -0.6, 0.0, i % 2 == 0 ? 0.8 : -0.8); }),
              alpha, "opposite normals", worst);
}

}  // namespace

std::vector<NumericalCase> one_lobe_cases() {
  std::vector<NumericalCase> cases;
  const auto edit = [](const char* text, const char* replacement) { return SourceEdit{"one_lobe", text, replacement}; };
  const auto add = [&](const char* name, const char* without, const char* guard, void (*run)(Device&, WorstError&),
                       const std::vector<SourceEdit>& edits) {
    cases.push_back(
        {{name, "one_lobe_finest, one_lobe_samples, one_lobe_fit", without, guard, 2e-4,
          "error (the larger of the absolute error of the normal and a tenth of the relative error of the roughness "
          "alpha)",
          "each of 5 EM steps adds 64 terms in float, so the error is about 1e-6 times the width of the lobe"},
         run,
         edits,
         {},
         {}});
  };
  add("mirrors-of-one-normal", "without spread and roughness, the scale matrix S of the slopes has no inverse",
      "variances are at least 1e-8", mirrors,
      {edit("s.xx = MAX_V(s.xx, (real_v)(SCALE_MIN));", ""), edit("s.yy = MAX_V(s.yy, (real_v)(SCALE_MIN));", "")});
  add("axes-of-round-lobes", "a round lobe has no axis, so computing the axis divides 0 by 0",
      "round lobes use the x axis as their axis", mirrors,
      {edit("has_axis ? ax / MAX_V(axis_length, (real_v)(1e-12f)) : (real_v)(1.0f)", "ax / axis_length"),
       edit("has_axis ? ay / MAX_V(axis_length, (real_v)(1e-12f)) : (real_v)(0.0f)", "ay / axis_length")});
  add("facets-behind-the-mean-normal", "slopes of facets below the horizon have the wrong sign",
      "slopes are at most 20", facets_behind,
      {edit("MAX_V(fma(hx, mx, fma(hy, my, hz * mz)), least)", "fma(hx, mx, fma(hy, my, hz * mz))")});
  add("normals-of-nothing-in-a-lobe", "one texel without a direction makes every coarser texel NaN",
      "a texel without a direction counts as flat", normals_of_nothing,
      {edit("(square > 1e-12f) & (square < 1e12f)", "(int_v)(-1)")});
  add("slopes-along-one-line", "the scale matrix S of the slopes is singular if all slopes are on one line",
      "the correlation of the slopes in x and y is at most 0.996", slopes_of_a_line,
      {edit("s.xy = MIN_V(MAX_V(s.xy, -most), most);", "")});
  add("lobes-beyond-alpha-1", "a fitted alpha can exceed 1, but files store roughness only up to 1",
      "alpha is at most 1", lobes_beyond_1,
      {edit("MIN_V(MAX_V(sqrt(2.0f * (middle + radius)), least), (real_v)(1.0f))",
            "MAX_V(sqrt(2.0f * (middle + radius)), least)")});
  add("a-lobe-of-opposite-normals", "a mean of length 0 has no direction, so normalising it divides by zero",
      "the lobe points straight up", no_mean_normal,
      {edit("*z = usable ? *z * inverse : (real_v)(1.0f);", "*z = *z * inverse;")});
  return cases;
}

}  // namespace multum
