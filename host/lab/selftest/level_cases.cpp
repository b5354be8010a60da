// SPDX-License-Identifier: Apache-2.0
// Tests the kernels that run before and after EM. They start a texel with its parent's lobes (movmf_start.cl), pack
// normals and binned normals (movmf_pack.cl), and make the finest level (movmf_level_zero.cl).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/lab/reference/movmf_em.h"
#include "host/lab/reference/planar_em.h"
#include "host/lab/selftest/buffers.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

// Returns the kernel parameters for one texel with one parent.
MultumMovmfFit one_texel_fit() {
  MultumMovmfFit fit = {};
  fit.map_width = fit.map_height = 2;
  fit.width = fit.height = fit.window_rows = 1;
  fit.parent_width = fit.parent_height = fit.parent_window_rows = 1;
  fit.map_window_rows = 2;
  fit.slot_count = MULTUM_GROUP;
  fit.start_kappa_factor = 0.5f;
  fit.start_amplitude_min = 0.02f;
  fit.alignment = 0.1f;
  return fit;
}

// Returns the starting planes of a texel whose parent is `parent`.
std::vector<double> start_from(Device& device, const MultumVmfLobe& parent, int width) {
  const std::vector<int> list(kGroup, 0);
  const MultumVmfLobe nothing = {};
  const DeviceBuffer parents = device.wrap_buffer(&parent, sizeof(parent), "parent");
  const DeviceBuffer level = device.wrap_buffer(&nothing, sizeof(nothing), "level");
  const DeviceBuffer alignment_vectors = device.wrap_buffer(&nothing, sizeof(nothing), "directions");
  const DeviceBuffer texels = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  std::vector<float> start(MULTUM_START_PLANES * kGroup, NAN);
  DeviceBuffer out = device.make_buffer(start.size() * sizeof(float), "start");
  device.write(out, start.data(), out.byte_count());
  device.kernel("movmf_start", "movmf_start", {1, width, false})
      .launch({kGroup / static_cast<std::size_t>(width)}, parents, level, alignment_vectors, texels, out,
              one_texel_fit());
  device.read(out, start.data(), out.byte_count());
  std::vector<double> planes;
  for (std::size_t p = 0; p < MULTUM_START_PLANES; ++p) planes.push_back(static_cast<double>(start[p * kGroup + 3]));
  return planes;
}

void add_start(Device& device, const MultumVmfLobe& parent, WorstError& worst) {
  const glm::dvec3 r(parent.mean_x, parent.mean_y, parent.mean_z);
  const double length = glm::length(r), bounded = std::min(length, 1.0 - 1e-6);
  const glm::dvec3 mu = length > 1e-12 ? r / length : glm::dvec3(0.0, 0.0, 1.0);
  const double kappa = std::clamp(0.5 * (length > 1e-12 ? reference::kappa_of_mean_length(bounded) : 0.0), 0.05, 1e6);
  const double amplitude = std::max(static_cast<double>(parent.amplitude), 0.02);
  const double log_weight = std::log2(amplitude * kappa / -std::expm1(-2.0 * kappa));
  for (const int width : {1, device.shape().vector_width}) {
    const std::vector<double> found = start_from(device, parent, width);
    const std::string input = fmt::format("|r| = {:.9g}, a = {:.3g}", length, parent.amplitude);
    for (int k = 0; k < 3; ++k) {
      worst.add(found[static_cast<std::size_t>(k)], mu[k], 1.0, input);
      // A vector of length 0 stays 0, because a lobe without a direction has no prior.
      const double prior = length > 1e-12 ? 0.1 * static_cast<double>(parent.amplitude) * mu[k] : 0.0;
      worst.add(found[MULTUM_START_PRIOR + static_cast<std::size_t>(k)], prior, 1.0, input);
    }
    worst.add(found[MULTUM_START_SHARPNESS] / std::numbers::log2e, kappa, kappa, input);
    worst.add(found[MULTUM_START_LOG], log_weight, 1.0, input);
  }
}

void starts_from_degenerate_lobes(Device& device, WorstError& worst) {
  for (const float amplitude : {0.0f, 1e-40f, 1e-6f, 0.5f, 1.0f}) {
    add_start(device, {0.0f, 0.0f, 0.0f, amplitude}, worst);
    add_start(device, {-0.0f, 1e-40f, 0.0f, amplitude}, worst);
    add_start(device, {0.0f, 1e-20f, 0.0f, amplitude}, worst);
    for (const float length : {1e-6f, 0.25f, 1.0f - 0x1p-10f, 1.0f - 0x1p-23f, 1.0f, 1.0f + 0x1p-20f}) {
      add_start(device, {0.0f, 0.0f, length, amplitude}, worst);
      add_start(device, {-length, 0.0f, 0.0f, amplitude}, worst);
      add_start(device, {0.0f, 0.0f, -length, amplitude}, worst);
    }
  }
}

// Returns the largest number of finest texels that a texel overlaps along one axis.
int span(int map_size, int level_size) {
  int most = 0;
  for (int t = 0; t < level_size; ++t)
    most = std::max(most, ((t + 1) * map_size + level_size - 1) / level_size - t * map_size / level_size);
  return most;
}

// Tests the sample weights of all texels of a level. The weights of each texel must add up to `W H / (w h)`. If a sum
// is larger, some finest texels are counted twice.
void add_coverage(Device& device, int map_width, int map_height, int level_number, WorstError& worst) {
  MultumMovmfFit fit = {};
  fit.map_width = map_width;
  fit.map_height = fit.map_window_rows = map_height;
  fit.width = mip_level_size(map_width, level_number);
  fit.height = fit.window_rows = mip_level_size(map_height, level_number);
  fit.sample_columns = span(map_width, fit.width);
  fit.sample_rows = span(map_height, fit.height);
  const auto texel_count = static_cast<std::size_t>(fit.width * fit.height);
  const std::size_t slots = (texel_count + kGroup - 1) / kGroup * kGroup;
  fit.slot_count = static_cast<int>(slots);
  std::vector<int> list(slots, -1);
  std::iota(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(texel_count), 0);
  const std::vector<float> plane(static_cast<std::size_t>(map_width * map_height), 0.5f);
  const DeviceBuffer normals = device.wrap_buffer(plane.data(), plane.size() * sizeof(float), "normals");
  const DeviceBuffer texels = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  const auto sample_count = static_cast<std::size_t>(fit.sample_columns * fit.sample_rows);
  std::vector<float> samples(slots * sample_count * 4, NAN);
  DeviceBuffer out = device.make_buffer(samples.size() * sizeof(float), "samples");
  device.write(out, samples.data(), out.byte_count());
  const DeviceBuffer counts = device.make_buffer(slots / kGroup * sizeof(int), "sample counts");
  device.kernel("movmf_pack", "movmf_pack", {4, 1, true})
      .launch({static_cast<std::size_t>(fit.sample_rows) * slots / kGroup}, normals, normals, normals, texels, out,
              counts, fit);
  device.read(out, samples.data(), out.byte_count());
  const double exact = static_cast<double>(map_width) * map_height / static_cast<double>(texel_count);
  for (std::size_t t = 0; t < texel_count; ++t) {
    double sum = 0.0;
    for (std::size_t i = 0; i < sample_count; ++i)
      sum += static_cast<double>(samples[((t / kGroup * sample_count + i) * 4 + 3) * kGroup + t % kGroup]);
    worst.add(sum, exact, exact, fmt::format("{} x {}, level {}, texel {}", map_width, map_height, level_number, t));
  }
}

void strips_and_odd_sizes(Device& device, WorstError& worst) {
  for (const auto& [width, height] : {std::pair{1, 37}, {37, 1}, {37, 21}, {21, 37}, {3, 2}, {64, 1}, {101, 63}})
    for (int level = 1; level < mip_level_count(width, height); ++level)
      add_coverage(device, width, height, level, worst);
}

// Tests normals that were shortened to include the width of a BRDF. For Gaussians, the kernel converts these normals to
// points and their scatter. Each texel has one normal. Some normals have length 0, and some are longer than 1.
void shortened_normals_as_points(Device& device, WorstError& worst) {
  for (const double length : {0.0, 1e-30, 1e-6, 0.5, 0.99, 1.0, 1.1}) {
    std::vector<float> planes[3];
    for (std::size_t i = 0; i < kGroup; ++i)
      for (int k = 0; k < 3; ++k)
        planes[k].push_back(static_cast<float>(length * tilted(6.0 * static_cast<double>(i), 0.7)[k]));
    MultumMovmfFit fit = {};
    fit.map_width = fit.width = fit.slot_count = MULTUM_GROUP;
    fit.map_height = fit.map_window_rows = fit.height = fit.window_rows = fit.sample_columns = fit.sample_rows = 1;
    fit.shortened = 1;
    std::vector<int> list(kGroup);
    std::iota(list.begin(), list.end(), 0);
    const DeviceBuffer samples = uploaded(device, std::vector<float>(4 * kGroup, kPoison), "samples");
    device.kernel("movmf_pack", "movmf_pack", {4, 1, true, true})
        .launch({1}, uploaded(device, planes[0], "x"), uploaded(device, planes[1], "y"),
                uploaded(device, planes[2], "z"), uploaded(device, list, "texels"), samples,
                uploaded(device, std::vector<int>(1), "sample counts"), fit);
    const std::vector<float> found = downloaded<float>(device, samples);
    for (std::size_t i = 0; i < kGroup; ++i) {
      const glm::dvec3 n(planes[0][i], planes[1][i], planes[2][i]);
      // Squares below 1e-38 are 0 in float, so these normals have no direction and get the largest scatter.
      const glm::dvec3 exact = length > 1e-12 ? reference::planar_sample(n, true) : glm::dvec3(0.0, 0.0, 1.0);
      for (int k = 0; k < 3; ++k)
        worst.add(static_cast<double>(found[static_cast<std::size_t>(k) * kGroup + i]), exact[k], 1.0,
                  fmt::format("length {}, normal {}, value {}", length, i, k));
    }
  }
}

// Tests adjacent texels with very different numbers of cells, a texel without cells, and slots without a texel. Missing
// cells must have weight 0, and the kernel must not read data after the last cell of a texel.
void uneven_cells_side_by_side(Device& device, WorstError& worst, int part_count) {
  constexpr int kCapacity = 40, kTexels = 20;
  MultumMovmfFit fit = {};
  fit.slot_count = 2 * MULTUM_GROUP;
  fit.sample_capacity = kCapacity;
  std::vector<int> counts, list(2 * kGroup, -1);
  std::vector<float> binned(kTexels * kCapacity * MULTUM_CONDENSED_SAMPLE, kPoison);
  for (int t = 0; t < kTexels; ++t) {
    counts.push_back(t == 0 ? kCapacity : (t * 7) % 11);
    for (int i = 0; i < counts.back() * MULTUM_CONDENSED_SAMPLE; ++i)
      binned[static_cast<std::size_t>(t * kCapacity * MULTUM_CONDENSED_SAMPLE + i)] =
          static_cast<float>(std::pow(-10.0, i % 31 - 15));
    list[static_cast<std::size_t>(t == 0 ? 2 : 11 + t)] =
        t;  // texel 0 is in slot 2; all others are at the end of group 1 or in group 2
  }
  const DeviceBuffer samples =
      uploaded(device, std::vector<float>(2 * kGroup * kCapacity * MULTUM_CONDENSED_SAMPLE, kPoison), "samples");
  const DeviceBuffer sample_counts = uploaded(device, std::vector<int>(2, -1), "sample counts");
  device.kernel("movmf_pack", "movmf_binned_pack", {1, 1, false})
      .launch({2 * static_cast<std::size_t>(part_count), 64}, uploaded(device, binned, "binned"),
              uploaded(device, counts, "counts"), uploaded(device, list, "texels"), samples, sample_counts, fit,
              part_count);
  const std::vector<float> found = downloaded<float>(device, samples);
  const std::vector<int> found_counts = downloaded<int>(device, sample_counts);
  for (std::size_t group = 0; group < 2; ++group) {
    int most = 1;
    for (std::size_t lane = 0; lane < kGroup; ++lane) {
      const int texel = list[group * kGroup + lane];
      if (texel >= 0) most = std::max(most, counts[static_cast<std::size_t>(texel)]);
    }
    worst.add(found_counts[group] == most ? 0.0 : 1.0, fmt::format("count of group {}", group));
    for (std::size_t i = 0; i < kCapacity; ++i)
      for (std::size_t k = 0; k < MULTUM_CONDENSED_SAMPLE; ++k)
        for (std::size_t lane = 0; lane < kGroup; ++lane) {
          const int texel = list[group * kGroup + lane], n = static_cast<int>(i);
          const auto at = static_cast<std::size_t>(texel * kCapacity + n) * MULTUM_CONDENSED_SAMPLE + k;
          const float value = found[((group * kCapacity + i) * MULTUM_CONDENSED_SAMPLE + k) * kGroup + lane];
          const bool has = texel >= 0 && n < counts[static_cast<std::size_t>(texel)];
          const float expected = n >= most ? kPoison : has ? binned[at] : k == 2 ? 1.0f : 0.0f;
          const bool same = std::isnan(expected) ? std::isnan(value) : value == expected;
          worst.add(same ? 0.0 : 1.0, fmt::format("group {}, lane {}, sample {}, value {}", group, lane, i, k));
        }
  }
}

// Tests packing with one work-item per group and with several work-items per group.
void uneven_cells_by_any_parts(Device& device, WorstError& worst) {
  for (const int part_count : {1, 3}) uneven_cells_side_by_side(device, worst, part_count);
}

// Returns, for each normal, the index of the lobe to which it is assigned.
std::vector<int> nearest_lobes(Device& device, const std::vector<MultumVmfLobe>& parent,
                               const std::vector<glm::vec3>& normals) {
  MultumMovmfFit fit = {};
  fit.map_width = static_cast<int>(normals.size());
  fit.map_height = 1;
  fit.width = fit.height = fit.window_rows = 1;
  std::vector<float> planes[3];
  for (const glm::vec3& n : normals)
    for (int k = 0; k < 3; ++k) planes[k].push_back(n[k]);
  const std::size_t bytes = normals.size() * sizeof(float);
  const DeviceBuffer x = device.wrap_buffer(planes[0].data(), bytes, "x"),
                     y = device.wrap_buffer(planes[1].data(), bytes, "y"),
                     z = device.wrap_buffer(planes[2].data(), bytes, "z"),
                     lobes = device.wrap_buffer(parent.data(), parent.size() * sizeof(MultumVmfLobe), "parent");
  std::vector<unsigned char> nearest(normals.size(), 255);
  DeviceBuffer out = device.make_buffer(nearest.size(), "nearest");
  device.write(out, nearest.data(), nearest.size());
  device.kernel("movmf_level_zero", "movmf_level_zero", {static_cast<int>(parent.size()), 1, false})
      .launch({normals.size()}, x, y, z, lobes, out, fit, 1, 0, 0, 1);
  device.read(out, nearest.data(), nearest.size());
  return {nearest.begin(), nearest.end()};
}

void a_dead_lobe_takes_nothing(Device& device, WorstError& worst) {
  const glm::vec3 n(0.6f, 0.0f, 0.8f), far(-0.6f, 0.0f, 0.8f);
  for (const float amplitude : {0.0f, 1e-40f, 1e-7f}) {
    const std::vector<MultumVmfLobe> parent = {{n.x, n.y, n.z, amplitude},
                                               {0.0f, 0.0f, 0.0f, amplitude},
                                               {far.x, far.y, far.z, 1.0f},
                                               {0.0f, 0.8f, 0.6f, 0.5f}};
    const std::vector<int> found = nearest_lobes(device, parent, {n, far, {0.0f, 1.0f, 0.0f}});
    const int expected[] = {3, 2, 3};
    for (std::size_t i = 0; i < found.size(); ++i)
      worst.add(found[i] == expected[i] ? 0.0 : 1.0, fmt::format("amplitude {}, normal {}", amplitude, i));
  }
}

// Tests a lobe of opposite normals, whose r is 0 or nearly 0, next to a wide lobe. Only the directions of lobes may
// affect the choice.
void directions_of_short_means(Device& device, WorstError& worst) {
  const glm::vec3 mu(0.6f, 0.0f, 0.8f);
  for (const float length : {0.0f, 1e-6f, 0.05f, 0.3f}) {
    const std::vector<MultumVmfLobe> parent = {
        {0.0f, 0.0f, -length, 0.5f},  // this lobe is opposite to all normals except the last
        {0.99f * mu.x, 0.0f, 0.99f * mu.z, 0.3f},
        {0.0f, 0.6f, 0.6f, 0.2f}};
    const std::vector<int> found = nearest_lobes(device, parent, {mu, {0.8f, 0.0f, 0.6f}, {0.0f, 0.8f, 0.6f}, -mu});
    const int expected[] = {1, 1, 2, 0};
    for (std::size_t i = 0; i < found.size(); ++i)
      worst.add(found[i] == expected[i] ? 0.0 : 1.0, fmt::format("|r| {}, normal {}", length, i));
  }
}

// A lobe without a direction counts as perpendicular to every normal, so it is closer to a normal than lobes that point
// away from the normal.
void a_lobe_of_no_direction(Device& device, WorstError& worst) {
  const glm::vec3 mu(0.6f, 0.0f, 0.8f);
  for (const float amplitude : {1e-5f, 0.5f}) {
    const std::vector<MultumVmfLobe> parent = {{0.9f * mu.x, 0.0f, 0.9f * mu.z, 0.5f}, {0.0f, 0.0f, 0.0f, amplitude}};
    const std::vector<int> found =
        nearest_lobes(device, parent, {mu, {-0.8f, 0.0f, 0.6001f}, {0.8f, 0.0f, -0.601f}, -mu});
    const int expected[] = {0, 0, 1, 1};
    for (std::size_t i = 0; i < found.size(); ++i)
      worst.add(found[i] == expected[i] ? 0.0 : 1.0, fmt::format("amplitude {}, normal {}", amplitude, i));
  }
}

// Every normal must get a valid lobe index, because later code uses it as an array index.
void any_normal_gets_a_lobe(Device& device, WorstError& worst) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<MultumVmfLobe> parent = {{0.0f, 0.0f, 0.9f, 0.5f}, {0.9f, 0.0f, 0.0f, 0.5f}};
  const std::vector<glm::vec3> normals = {{kNan, 0.0f, 1.0f},   {HUGE_VALF, 0.0f, 0.0f}, {-HUGE_VALF, HUGE_VALF, 0.0f},
                                          {0.0f, 0.0f, 0.0f},   {-0.0f, 1e-40f, -0.0f},  {0.0f, 0.0f, -1.0f},
                                          {3e38f, 3e38f, 3e38f}};
  const std::vector<int> found = nearest_lobes(device, parent, normals);
  for (std::size_t i = 0; i < found.size(); ++i)
    worst.add(found[i] >= 0 && found[i] < 2 ? 0.0 : 1.0, fmt::format("normal {}", i));
}

}  // namespace

std::vector<NumericalCase> level_cases() {
  return {
      {{"starts-from-degenerate-lobes", "movmf_start",
        "normalising a mean r of length 0 divides by zero, and a mean r longer than 1 gives a negative kappa",
        "a mean r of length 0 is replaced by +z, |r| is at most 1, the spread is at least 1e-6, and amplitudes are at "
        "least 0.02",
        1e-4,
        "absolute error of the direction mu, the prior C a mu and log2 of the weight (or relative error of kappa)",
        "kappa and its logarithm have errors of 3.3e-5"},
       starts_from_degenerate_lobes,
       {{"movmf_start", "const int_v directed = squared > 1e-24f;", "const int_v directed = squared >= 0.0f;"}}},
      {{"strips-and-odd-sizes", "movmf_pack", "a finest texel on a border counts fully in both coarser texels",
        "the weight of a finest texel is the covered fraction, so each finest texel counts once per level", 1e-6,
        "relative error of a texel's weight", "the weight of each sample is rounded once"},
       strips_and_odd_sizes,
       {{"movmf_pack", "return (float)max(high - low, 0) / (float)level_size;", "return high > low ? 1.0f : 0.0f;"}}},
      {{"shortened-normals-as-points", "movmf_pack (planar)",
        "a normal of length 0 has no projected point, so its facets would lie outside the unit circle",
        "the divisor is at least 1e-6, and the scatter is at most 1 - |p|^2", 1e-6, "absolute error",
        "a square root and two quotients are rounded, and the difference 1 - |p|^2 loses digits by cancellation"},
       shortened_normals_as_points,
       {{"movmf_pack", "MAX_V(length, (real)(1e-6f))", "length"}}},
      {{"uneven-cells-side-by-side", "movmf_binned_pack",
        "the kernel counts data after the last cell of a texel as samples of the texel",
        "the kernel pads every texel to the largest number of samples, with samples of weight 0", kNothingWrong,
        "wrong values", "the kernel only copies values, so they must not change"},
       uneven_cells_by_any_parts,
       {{"movmf_pack", "i < count ? vload4(i, in) : (float4)(0.0f, 0.0f, 1.0f, 0.0f)", "vload4(i, in)"}}},
      {{"a-dead-lobe-takes-nothing", "movmf_level_zero",
        "the kernel chooses a lobe without normals or without a direction as the closest lobe",
        "lobes with amplitudes up to 1e-6 are ignored", kNothingWrong, "wrong texels", "every texel must be correct"},
       a_dead_lobe_takes_nothing,
       {{"movmf_level_zero", "(amplitude > 1e-6f) & (gap < least)", "gap < least"}}},
      {{"directions-of-short-means", "movmf_level_zero",
        "a wide lobe has a short mean r, so |r| - n . r is small even for normals n far from the lobe",
        "the kernel compares cosines, so it divides n . r by |r|", kNothingWrong, "wrong texels",
        "every texel must be correct"},
       directions_of_short_means,
       {{"movmf_level_zero", "1.0f - along / MAX_V(length, (real_v)(1e-12f))", "length - along"}}},
      {{"a-lobe-of-no-direction", "movmf_level_zero",
        "a mean r of length 0 is divided by its length, which gives NaN, and a lobe with a cosine of NaN is never the "
        "closest lobe",
        "the divisor is at least 1e-12, so the cosine is 0", kNothingWrong, "wrong texels",
        "every texel must be correct"},
       a_lobe_of_no_direction,
       {{"movmf_level_zero", "MAX_V(length, (real_v)(1e-12f))", "length"}}},
      {{"any-normal-gets-a-lobe", "movmf_level_zero", "comparisons with NaN are false, so no index is written",
        "the kernel writes lobe 0 unless another lobe is closer", kNothingWrong, "wrong texels",
        "every texel must be correct"},
       any_normal_gets_a_lobe,
       {},
       {},
       {{"movmf_level_zero", "int_v lobe_of_least = (int_v)(0);", "int_v lobe_of_least = (int_v)(255);"}}},
  };
}

}  // namespace multum
