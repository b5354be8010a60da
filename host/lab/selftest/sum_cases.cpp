// SPDX-License-Identifier: Apache-2.0
// Tests sums over 2^28 texels, the largest number that a texel of a level can cover. The input repeats one band of
// normals, so its exact sum is known. The cases test sums of chunks (movmf_em_chunks.cl, movmf_em_mstep.cl), of colours
// (movmf_features.cl) and of cells (movmf_binning.cl).
//
// A sum in a single float is not sufficient. At 2^24, the sum stops growing, because each increment is less than half a
// unit in the last place. If 2^16 exact partial sums are added, each addition loses up to half a unit in the last place
// of the total. If the input repeats a pattern, all losses have the same direction.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/split_mix.h"
#include "host/lab/reference/coverage.h"
#include "host/lab/selftest/buffers.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"
#include "host/lab/selftest/feature_launch.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

constexpr int kWidth = 32768, kHeight = 8192;  // the texel of the coarsest level covers 2^28 texels
constexpr int kBandRows = 64;
constexpr double kTexels = 0x1p28;
constexpr int kChunks = 1 << 16;  // chunks of 4096 normals each

// Contains 64 rows of normals around a tilted direction, and their sum in double precision.
struct Band {
  std::vector<float> planes[3];
  glm::dvec3 sum = glm::dvec3(0.0);
  double mean_gap = 0.0;  // mean of 1 - n . mu
  glm::dvec3 mu;
};

const Band& band() {
  static const Band made = [] {
    Band b;
    b.mu = glm::dvec3(glm::vec3(tilted(20.0)));
    SplitMix64 random(28);
    constexpr std::size_t kCount = static_cast<std::size_t>(kWidth) * kBandRows;
    for (auto& plane : b.planes) plane.resize(kCount + kGroup, 0.0f);
    for (std::size_t i = 0; i < kCount; ++i) {
      const double x = random.uniform() - 0.5, y = random.uniform() - 0.5;
      const glm::vec3 n(glm::normalize(b.mu + 0.4 * glm::dvec3(x, y, 0.0)));
      for (int k = 0; k < 3; ++k) b.planes[k][i] = n[k];
      b.sum += glm::dvec3(n);
      b.mean_gap += 1.0 - glm::dot(glm::dvec3(n), b.mu);
    }
    b.mean_gap /= static_cast<double>(kCount);
    return b;
  }();
  return made;
}

MultumMovmfFit coarsest_fit() {
  MultumMovmfFit fit = {};
  fit.map_width = fit.sample_columns = kWidth;
  fit.map_height = fit.sample_rows = kHeight;
  fit.width = fit.height = fit.window_rows = 1;
  fit.slot_count = MULTUM_GROUP;
  fit.iteration_count = 1;
  fit.kappa_cap = 500.0f;
  fit.kappa_cap_slope = 10.0f;
  fit.chunk_rows = 1;
  fit.chunk_count = kHeight;
  fit.map_window_rows = kBandRows;
  fit.total_weight_inverse = static_cast<float>(1.0 / kTexels);
  return fit;
}

std::vector<int> one_slot() {
  std::vector<int> list(kGroup, -1);
  list[0] = 0;
  return list;
}

}  // namespace

std::vector<std::vector<glm::vec3>> feature_partials(Device& device, const FeatureMap& map,
                                                     const std::vector<EmTexel>& texels) {
  MultumMovmfFit fit = coarsest_fit();
  fit.map_width = map.width, fit.map_height = fit.map_window_rows = map.height;
  fit.width = map.level_width, fit.height = fit.window_rows = map.level_height;
  // Returns the largest number of columns that a texel can overlap.
  fit.sample_columns = (map.width + map.level_width - 1) / map.level_width + 1;
  fit.sample_rows = (map.height + map.level_height - 1) / map.level_height + 1;
  fit.chunk_rows = map.chunk_rows, fit.chunk_count = map.chunk_count;
  std::vector<float> planes[6];
  for (int c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < map.normals.size(); ++i) {
      planes[c].push_back(map.normals[i][c]);
      planes[3 + c].push_back(map.values[i][c]);
    }
  std::vector<int> list(kGroup, -1);
  for (int t = 0; t < map.level_width * map.level_height; ++t) list[static_cast<std::size_t>(t)] = t;
  const std::size_t lobes = texels.front().lobes.size(), chunks = static_cast<std::size_t>(map.chunk_count);
  const DeviceBuffer partial =
      uploaded(device, std::vector<float>(kGroup * chunks * lobes * 3, kPoison), "partial sums");
  device.kernel("movmf_features", "movmf_feature_partial", {static_cast<int>(lobes), 1, false})
      .launch({kGroup * chunks, 64}, uploaded(device, planes[0], "x"), uploaded(device, planes[1], "y"),
              uploaded(device, planes[2], "z"), uploaded(device, planes[3], "red"),
              uploaded(device, planes[4], "green"), uploaded(device, planes[5], "blue"),
              uploaded(device, packed_start(texels), "start"), uploaded(device, list, "texels"), partial, fit);
  const std::vector<float> sums = downloaded<float>(device, partial);
  std::vector<std::vector<glm::vec3>> of_slots(kGroup);
  for (std::size_t i = 0; i < sums.size(); i += 3)
    of_slots[i / (chunks * lobes * 3)].emplace_back(sums[i], sums[i + 1], sums[i + 2]);
  return of_slots;
}

namespace {

// Runs the M-step on the chunks in `partial`, and returns (r, a) of each lobe.
std::vector<MultumVmfLobe> lobes_of_chunks(Device& device, const DeviceBuffer& partial, const EmTexel& texel,
                                           const MultumMovmfFit& fit) {
  const std::vector<float> start = packed_start({texel});
  const std::vector<int> list = one_slot();
  DeviceBuffer start_buffer = device.make_buffer(start.size() * sizeof(float), "start");
  device.write(start_buffer, start.data(), start_buffer.byte_count());
  const DeviceBuffer texels = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  std::vector<MultumVmfLobe> lobes(texel.lobes.size(), MultumVmfLobe{NAN, NAN, NAN, NAN});
  DeviceBuffer level = device.make_buffer(lobes.size() * sizeof(MultumVmfLobe), "lobes");
  device.write(level, lobes.data(), level.byte_count());
  const DeviceBuffer alignment_vectors = device.make_buffer(level.byte_count(), "directions");
  device.kernel("movmf_em_mstep", "movmf_em_mstep", {static_cast<int>(lobes.size()), 1, false})
      .launch({lobes.size()}, partial, start_buffer, texels, level, alignment_vectors, fit, 0);
  device.read(level, lobes.data(), level.byte_count());
  return lobes;
}

void texels_2_28_by_chunks(Device& device, WorstError& worst) {
  const Band& b = band();
  const EmTexel texel{{}, {{b.mu, 100.0, 1.0}}};
  MultumMovmfFit fit = coarsest_fit();
  const std::vector<float> start = packed_start({texel});
  const std::vector<int> list = one_slot();
  const DeviceBuffer start_buffer = device.wrap_buffer(start.data(), start.size() * sizeof(float), "start");
  const DeviceBuffer texels = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  const std::size_t bytes = b.planes[0].size() * sizeof(float);
  const DeviceBuffer x = device.wrap_buffer(b.planes[0].data(), bytes, "x"),
                     y = device.wrap_buffer(b.planes[1].data(), bytes, "y"),
                     z = device.wrap_buffer(b.planes[2].data(), bytes, "z");
  DeviceBuffer partial = device.make_buffer(static_cast<std::size_t>(kHeight) * 5 * sizeof(float), "partial sums");
  device.fill_zero(partial);
  const int width = device.shape().vector_width;
  const std::size_t items = static_cast<std::size_t>(kHeight) * kGroup / static_cast<std::size_t>(width);
  Kernel sums = device.kernel("movmf_em_chunks", "movmf_em_partial", {1, width, false});
  for (fit.map_first_row = 0; fit.map_first_row < kHeight; fit.map_first_row += kBandRows)
    sums.launch({items, width == 1 ? kGroup : 0}, x, y, z, start_buffer, texels, partial, fit);
  const MultumVmfLobe lobe = lobes_of_chunks(device, partial, texel, fit).front();
  const glm::dvec3 mean = b.sum / (static_cast<double>(kWidth) * kBandRows);
  worst.add(static_cast<double>(lobe.amplitude), 1.0, 1.0, "amplitude");
  worst.add(glm::length(glm::dvec3(lobe.mean_x, lobe.mean_y, lobe.mean_z) - mean), "r");
}

// Tests the addition of 2^16 partial sums, each of which is rounded to float.
void many_partial_sums(Device& device, WorstError& worst) {
  EmTexel texel{{}, {{tilted(20.0), 100.0, 0.5}, {tilted(60.0, 2.0), 100.0, 0.5}}};
  MultumMovmfFit fit = coarsest_fit();
  fit.chunk_count = kChunks;
  SplitMix64 random(16);
  std::vector<float> partial(static_cast<std::size_t>(kChunks) * 2 * 5);
  double share[2] = {0.0, 0.0};
  glm::dvec3 sum[2] = {glm::dvec3(0.0), glm::dvec3(0.0)};
  for (std::size_t i = 0; i < partial.size(); i += 5) {
    const std::size_t j = i / 5 % 2;
    const double s = j == 0 ? 3000.3 : 4096.0 - 3000.3;
    const glm::dvec3 n = s * 0.98 * texel.lobes[j].mu + random.uniform() * glm::dvec3(1.0, 0.5, -0.5);
    const double values[5] = {s, n.x, n.y, n.z, s - glm::dot(n, texel.lobes[j].mu)};
    for (std::size_t k = 0; k < 5; ++k) partial[i + k] = static_cast<float>(values[k]);
    share[j] += static_cast<double>(partial[i]);
    sum[j] += glm::dvec3(partial[i + 1], partial[i + 2], partial[i + 3]);
  }
  const DeviceBuffer buffer = device.wrap_buffer(partial.data(), partial.size() * sizeof(float), "partial sums");
  const std::vector<MultumVmfLobe> found = lobes_of_chunks(device, buffer, texel, fit);
  for (std::size_t j = 0; j < 2; ++j) {
    worst.add(static_cast<double>(found[j].amplitude), share[j] / kTexels, 1.0, fmt::format("amplitude {}", j));
    worst.add(glm::length(glm::dvec3(found[j].mean_x, found[j].mean_y, found[j].mean_z) - sum[j] / share[j]),
              fmt::format("r {}", j));
  }
}

// Tests 2^16 chunks with colours of 1e-6, 1 and 1e6.
void many_partial_colours(Device& device, WorstError& worst) {
  MultumMovmfFit fit = coarsest_fit();
  fit.chunk_count = kChunks;
  std::vector<float> partial(static_cast<std::size_t>(kChunks) * 3);
  double sum[3] = {0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < partial.size(); ++i) {
    partial[i] = static_cast<float>(4096.0 * 0.7301 * std::pow(10.0, 6.0 * (static_cast<double>(i % 3) - 1.0)));
    sum[i % 3] += static_cast<double>(partial[i]) / kTexels;
  }
  const std::vector<int> list = one_slot();
  const DeviceBuffer in = device.wrap_buffer(partial.data(), partial.size() * sizeof(float), "partial sums");
  const DeviceBuffer texels = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  std::vector<float> colours(3, NAN);
  DeviceBuffer out = device.make_buffer(colours.size() * sizeof(float), "colours");
  device.write(out, colours.data(), out.byte_count());
  device.kernel("movmf_features", "movmf_feature_sum", {1, 1, false}).launch({1}, in, texels, out, fit, 0);
  device.read(out, colours.data(), out.byte_count());
  for (std::size_t c = 0; c < 3; ++c)
    worst.add(static_cast<double>(colours[c]), sum[c], sum[c], fmt::format("channel {}", c));
}

// Returns the first lobe's share of a normal. Both lobes have the same sharpness and amplitude.
double share_of_first(const EmTexel& texel, const glm::dvec3& n) {
  const auto exponent = [&](std::size_t j) {
    return texel.lobes[j].kappa * glm::dot(glm::dvec3(glm::vec3(texel.lobes[j].mu)), n);
  };
  return 1.0 / (1.0 + std::exp(exponent(1) - exponent(0)));
}

EmTexel two_lobes(double kappa) { return {{}, {{tilted(10.0, 0.0), kappa, 0.5}, {tilted(10.0, 1.5), kappa, 0.5}}}; }

glm::dvec3 far_normal(int i) { return glm::dvec3(glm::vec3(tilted(60.0, i % 2 == 0 ? 0.1 : 1.4))); }
glm::dvec3 colour_of_contrast(int i) { return glm::dvec3(glm::vec3(glm::dvec3(1e-6, 1.0, 1e6) * (0.5 + 0.01 * i))); }

// Tests the partial sums of two texels, which share a column of a map with 37 x 21 texels. One chunk has fewer rows
// than the others, and one chunk has no rows. Slots without a texel must not be written. The second texel has the lobes
// of the first texel in another order.
void colours_of_uneven_chunks(Device& device, WorstError& worst) {
  FeatureMap map{37, 21, 2, 1, 4, 7, {}, {}};
  for (int i = 0; i < map.width * map.height; ++i) {
    map.normals.push_back(glm::vec3(far_normal(i)));
    map.values.push_back(glm::vec3(colour_of_contrast(i % 64)));
  }
  for (const double kappa : {0.05, 100.0, 1e6}) {
    std::vector<EmTexel> texels(2, two_lobes(kappa));
    std::swap(texels[1].lobes[0], texels[1].lobes[1]);
    const std::vector<std::vector<glm::vec3>> found = feature_partials(device, map, texels);
    for (std::size_t slot = 0; slot < found.size(); ++slot)
      for (int chunk = 0; chunk < map.chunk_count; ++chunk) {
        const glm::vec3* sums = &found[slot][static_cast<std::size_t>(2 * chunk)];
        const std::string input = fmt::format("kappa {}, slot {}, chunk {}", kappa, slot, chunk);
        if (slot >= 2) {
          worst.add(std::isnan(sums[0].x) && std::isnan(sums[1].z) ? 0.0 : 1.0, input);
          continue;
        }
        glm::dvec3 exact[2] = {glm::dvec3(0.0), glm::dvec3(0.0)};
        const int first_row = chunk * map.chunk_rows;
        for (int row = first_row; row < std::min(first_row + map.chunk_rows, map.height); ++row)
          for (int column = 0; column < map.width; ++column) {
            const int i = row * map.width + column;
            const double weight = reference::overlap(column, static_cast<int>(slot), map.width, map.level_width),
                         share = share_of_first(texels[slot], far_normal(i));
            exact[0] += weight * share * colour_of_contrast(i % 64);
            exact[1] += weight * (1.0 - share) * colour_of_contrast(i % 64);
          }
        for (int j = 0; j < 2; ++j)
          for (int c = 0; c < 3; ++c)
            worst.add(static_cast<double>(sums[j][c]), exact[j][c], std::max(exact[0][c] + exact[1][c], 1e-30), input);
      }
  }
}

// Tests the colours of normals that are far from every lobe. The contrast is 1e6, and weights range from 2^-20 to 1.
void colours_far_from_every_lobe(Device& device, WorstError& worst) {
  for (const double kappa : {0.05, 100.0, 1e6}) {
    EmTexel texel = two_lobes(kappa), colour;
    double total = 0.0;
    glm::dvec3 exact[2] = {glm::dvec3(0.0), glm::dvec3(0.0)};
    for (int i = 0; i < 64; ++i) {
      const glm::dvec3 n = far_normal(i), y = colour_of_contrast(i);
      const double weight = std::exp2(-(i % 21)), z0 = share_of_first(texel, n);
      texel.samples.push_back({n, weight});
      colour.samples.push_back({y, weight});
      total += weight;
      exact[0] += z0 * weight * y;
      exact[1] += (1.0 - z0) * weight * y;
    }
    colour.lobes = texel.lobes;
    MultumMovmfFit fit = coarsest_fit();
    fit.sample_capacity = 64;
    fit.total_weight_inverse = static_cast<float>(1.0 / total);
    const std::vector<float> normals = packed_samples({texel}), values = packed_samples({colour}),
                             start = packed_start({texel});
    const std::vector<int> list = one_slot(), counts = {64};
    std::vector<float> colours(6, NAN);
    DeviceBuffer out = device.make_buffer(colours.size() * sizeof(float), "colours");
    device.write(out, colours.data(), out.byte_count());
    device.kernel("movmf_features", "movmf_feature_binned", {2, 1, false})
        .launch({1}, device.wrap_buffer(normals.data(), normals.size() * sizeof(float), "samples"),
                device.wrap_buffer(values.data(), values.size() * sizeof(float), "colours"),
                device.wrap_buffer(counts.data(), sizeof(int), "sample counts"),
                device.wrap_buffer(start.data(), start.size() * sizeof(float), "start"),
                device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels"), out, fit, 0);
    device.read(out, colours.data(), out.byte_count());
    for (std::size_t j = 0; j < 2; ++j)
      for (int c = 0; c < 3; ++c)
        worst.add(static_cast<double>(colours[j * 3 + static_cast<std::size_t>(c)]), exact[j][c] / total,
                  (exact[0][c] + exact[1][c]) / total, fmt::format("kappa {}, lobe {}, channel {}", kappa, j, c));
  }
}

constexpr int kSide = 31, kCells = kSide * kSide;

// Returns the axes of a grid that covers the whole disc.
std::vector<float> even_axes() {
  std::vector<float> axes;
  for (int k = 0; k < 2; ++k) {
    axes.push_back(-1.0f);
    axes.push_back(static_cast<float>(MULTUM_AXIS_BINS) / 2.0f);
    for (int b = 0; b <= MULTUM_AXIS_BINS; ++b)
      axes.push_back(static_cast<float>(kSide) * static_cast<float>(b) / static_cast<float>(MULTUM_AXIS_BINS));
  }
  return axes;
}

// Tests chunks that have their own tables, and chunks that share one table.
void texels_2_28_into_cells(Device& device, WorstError& worst, bool atomic) {
  const Band& b = band();
  MultumMovmfFit fit = coarsest_fit();
  fit.cell_side = kSide;
  fit.sample_capacity = kCells;
  const int chunk_count = atomic ? 1 : 8, strip_rows = 5;
  const int strip_count = (kBandRows + strip_rows - 1) / strip_rows;
  const std::vector<float> axis_values = even_axes();
  const std::size_t bytes = b.planes[0].size() * sizeof(float);
  const DeviceBuffer x = device.wrap_buffer(b.planes[0].data(), bytes, "x"),
                     y = device.wrap_buffer(b.planes[1].data(), bytes, "y"),
                     z = device.wrap_buffer(b.planes[2].data(), bytes, "z"),
                     axes = device.wrap_buffer(axis_values.data(), axis_values.size() * sizeof(float), "axes");
  std::vector<std::int64_t> cells(static_cast<std::size_t>(chunk_count) * kCells * MULTUM_CELL_SUMS, 0);
  DeviceBuffer out = device.make_buffer(cells.size() * sizeof(std::int64_t), "cells");
  device.fill_zero(out);
  Kernel add = atomic ? device.kernel("movmf_binning_team", "movmf_bin_add", {1, 1, false})
                      : device.kernel("movmf_binning", "movmf_bin_cells", {1, 1, false});
  const auto add_band = [&](int index) {
    fit.map_first_row = index * kBandRows;
    if (atomic)
      add.launch({static_cast<std::size_t>(fit.sample_columns) * static_cast<std::size_t>(strip_count)}, x, y, z, x, y,
                 z, axes, out, fit, 0, strip_rows, strip_count, 1);
    else add.launch({static_cast<std::size_t>(chunk_count)}, x, y, z, x, y, z, axes, out, fit, 0, chunk_count, 1);
    device.read(out, cells.data(), out.byte_count());
  };
  // All bands are equal, so each band adds the same integers. The test therefore multiplies the result of the first
  // band, and adds only the last band separately.
  constexpr int kBands = kHeight / kBandRows;
  add_band(0);
  for (std::int64_t& cell : cells) cell *= kBands - 1;
  device.write(out, cells.data(), out.byte_count());
  add_band(kBands - 1);
  double sum[4] = {0.0, 0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < cells.size(); ++i) sum[i % 4] += static_cast<double>(cells[i]) * 0x1p-30;
  const glm::dvec3 exact = b.sum * static_cast<double>(kBands);
  for (int k = 0; k < 3; ++k) worst.add(sum[k], exact[k], kTexels, fmt::format("component {}", k));
  worst.add(sum[3], kTexels, kTexels, "weight");
}

void texels_2_28_by_any_way(Device& device, WorstError& worst) {
  texels_2_28_into_cells(device, worst, false);
  if (device.info().has_atomic_longs) texels_2_28_into_cells(device, worst, true);
}

// Computes each of the same sums in a single float.
void floats_stand_still(WorstError& worst) {
  const Band& b = band();
  constexpr std::size_t kCount = static_cast<std::size_t>(kWidth) * kBandRows;
  float sum = 0.0f;
  for (int repeat = 0; repeat < kHeight / kBandRows; ++repeat)
    for (std::size_t i = 0; i < kCount; ++i) sum += b.planes[2][i];
  worst.add(static_cast<double>(sum), b.sum.z * (static_cast<double>(kHeight) / kBandRows), kTexels, "component 2");
}

// Tests cells that contain 2^28 normals in total. Their sums are integers up to 2^58, in units of 2^-30.
void means_of_2_58(Device& device, WorstError& worst, bool by_team) {
  const int chunk_count = 4;
  std::vector<std::int64_t> cells(static_cast<std::size_t>(chunk_count) * 3 * MULTUM_CELL_SUMS, 0);
  const double means[3][3] = {{0.1, -0.2, 0.97}, {-1.0, 1.0, 1e-9}, {0.3, 0.4, 0.5}};
  const double weights[3] = {0x1p28, 1.0, 0.0};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::size_t cell = i / 4 % 3;
    const double value = (i % 4 == 3 ? 1.0 : means[cell][i % 4]) * weights[cell] * 0x1p30 / chunk_count;
    cells[i] = static_cast<std::int64_t>(value);
  }
  const DeviceBuffer in = device.wrap_buffer(cells.data(), cells.size() * sizeof(std::int64_t), "cells");
  std::vector<float> samples(3 * MULTUM_CONDENSED_SAMPLE, NAN);
  DeviceBuffer out = device.make_buffer(samples.size() * sizeof(float), "samples"),
               counts = device.make_buffer(sizeof(int), "counts");
  device.write(out, samples.data(), out.byte_count());
  Kernel add_up = by_team ? device.kernel("movmf_binning_team", "movmf_bin_team_means", {1, 1, false})
                          : device.kernel("movmf_binning", "movmf_bin_means", {1, 1, false});
  add_up.launch(by_team ? Kernel::WorkSize{MULTUM_TEAM, MULTUM_TEAM} : Kernel::WorkSize{1}, in, out, counts, 1,
                chunk_count, 3, 1);
  device.read(out, samples.data(), out.byte_count());
  int count = 0;
  device.read(counts, &count, sizeof(count));
  worst.add(count, 2.0, 1.0, "cells that hold anything");
  for (std::size_t cell = 0; cell < 2; ++cell) {
    for (std::size_t k = 0; k < 3; ++k)
      worst.add(static_cast<double>(samples[cell * 4 + k]), means[cell][k], 1.0, fmt::format("cell {}", cell));
    worst.add(static_cast<double>(samples[cell * 4 + 3]), weights[cell], weights[cell],
              fmt::format("weight of cell {}", cell));
  }
}

void means_of_2_58_by_any_form(Device& device, WorstError& worst) {
  for (const bool by_team : {false, true}) means_of_2_58(device, worst, by_team);
}

// Tests probes that all have the same position, and probes without a position. A normal straight down has no position,
// because it maps to the whole rim of the disc.
void axes_of_no_extent(Device& device, WorstError& worst) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (const glm::vec3& n :
       {glm::vec3(0.0f, 0.0f, 1.0f), glm::vec3(0.3f, -0.4f, 0.866f), glm::vec3(0.0f, 0.0f, -1.0f)}) {
    MultumMovmfFit fit = coarsest_fit();
    fit.map_width = fit.map_height = fit.sample_columns = fit.sample_rows = fit.map_window_rows = 32;
    fit.cell_side = kSide;
    const std::vector<float> x(1024, n.x), y(1024, n.y), z(1024, n.z), poison(2 * MULTUM_PROBE_COUNT, kNan);
    const DeviceBuffer xb = device.wrap_buffer(x.data(), 4096, "x"), yb = device.wrap_buffer(y.data(), 4096, "y"),
                       zb = device.wrap_buffer(z.data(), 4096, "z");
    DeviceBuffer probes = device.make_buffer(poison.size() * sizeof(float), "probes");
    device.write(probes, poison.data(), probes.byte_count());
    std::vector<float> axes(2 * MULTUM_AXIS_FLOATS, kNan);
    DeviceBuffer axis_buffer = device.make_buffer(axes.size() * sizeof(float), "axes");
    device.write(axis_buffer, axes.data(), axis_buffer.byte_count());
    device.kernel("movmf_binning", "movmf_bin_probe", {1, 1, false})
        .launch({MULTUM_PROBE_SIDE}, xb, yb, zb, probes, fit, 0);
    device.kernel("movmf_binning", "movmf_bin_axes", {1, 1, false}).launch({2}, probes, axis_buffer, fit, 0);
    device.read(axis_buffer, axes.data(), axis_buffer.byte_count());
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const double value = static_cast<double>(axes[i]);
      // The first two values of an axis must be finite. The others are cell positions between 0 and the side length.
      const bool sane = i % MULTUM_AXIS_FLOATS < 2 ? std::isfinite(value) : value >= 0.0 && value <= kSide * 1.00001;
      worst.add(sane ? 0.0 : 1.0,
                fmt::format("normal ({}, {}, {}), value {} of the axes: {}", n.x, n.y, n.z, i, value));
    }
  }
}

}  // namespace

std::vector<NumericalCase> sum_cases() {
  const std::string plain = "*sum = *sum + value;\n  return;", compensated = "const float total = *sum + value;";
  return {
      {{"texels-2-to-28-by-chunks", "movmf_em_partial",
        "a float sum stops growing at 2^24, which loses 94 % of the total, and plain sums of chunks are all rounded in "
        "the same direction",
        "the kernel adds the sums of a chunk's 16 lanes as a tree, and adds the chunks by compensated summation", 1e-6,
        "absolute error of a and r",
        "each of 16 lanes makes 2048 additions, whose random errors reach 2048 * 2^-25 / 16"},
       texels_2_28_by_chunks,
       {{"movmf_em_mstep", compensated, plain + compensated}}},
      {{"sums-of-65536-partial-sums", "movmf_em_mstep",
        "each addition rounds by half a unit in the last place, always in the same direction",
        "the kernel uses Neumaier's compensated summation", 3e-7, "absolute error of a and r",
        "only a few rounding errors remain, no matter how many sums are added"},
       many_partial_sums,
       {{"movmf_em_mstep", compensated, plain + compensated}}},
      {{"colours-of-65536-partial-sums", "movmf_feature_sum",
        "each addition rounds by half a unit in the last place, always in the same direction",
        "the kernel uses Neumaier's compensated summation", 3e-7, "relative error",
        "only a few rounding errors remain, no matter how many sums are added"},
       many_partial_colours,
       {{"movmf_features", compensated, plain + compensated}}},
      {{"colours-far-from-every-lobe", "movmf_feature_binned",
        "every density is 0 in float, so the shares of the lobes are 0 divided by 0",
        "the kernel computes logarithms of densities and subtracts the largest logarithm", 1e-4,
        "of the channel's total", "logarithms near 1e6 have relative rounding errors of 6e-8, which change the shares"},
       colours_far_from_every_lobe,
       {{"movmf_features", "z[j] = exp2_v(z[j] - largest);", "z[j] = exp2(z[j]);"}}},
      {{"colours-of-uneven-chunks", "movmf_feature_partial",
        "the shares of the lobes are 0 divided by 0, or a finest texel on a border counts fully in both coarser texels",
        "the kernel subtracts the largest logarithm of a density, weights are fractions, and a chunk without rows "
        "gives 0",
        1e-4, "of the channel's total over the chunk",
        "logarithms near 1e6 have relative rounding errors of 6e-8, which change the shares"},
       colours_of_uneven_chunks,
       {{"movmf_features", "z[j] = exp2_v(z[j] - largest);", "z[j] = exp2(z[j]);"}}},
      {{"texels-2-to-28-into-cells", "movmf_bin_cells, movmf_bin_add", "a float sum stops growing at 2^24",
        "the kernel adds 64-bit integers in units of 2^-30, with sums up to 2^58, in any order", 2e-9,
        "absolute error of means", "each normal is rounded towards 0 in steps of 2^-30"},
       texels_2_28_by_any_way,
       {},
       floats_stand_still},
      {{"means-of-sums-to-2-to-58", "movmf_bin_means, movmf_bin_team_means", "a 32-bit sum overflows after two normals",
        "integers have 64 bits", 2e-7, "error of means (absolute) and of weights (relative)",
        "only two conversions and a division are rounded"},
       means_of_2_58_by_any_form,
       {{"movmf_binning", "long4 sum = vload4(cell, chunks);",
         "long4 sum = convert_long4(convert_int4(vload4(cell, chunks)));"},
        {"movmf_binning_team", "long4 sum = vload4(cell, chunks);",
         "long4 sum = convert_long4(convert_int4(vload4(cell, chunks)));"}}},
      {{"axes-of-no-extent", "movmf_bin_probe, movmf_bin_axes",
        "the number of bins (63) is divided by an extent of 0, and projecting a normal that points straight down "
        "divides 0 by 0",
        "the extent and 1 + z are at least 1e-6", kNothingWrong, "invalid axis values", "every axis must be valid"},
       axes_of_no_extent,
       {{"movmf_binning", "MAX_V(high - low, 1e-6f)", "(high - low)"},
        {"movmf_binning", "sqrt(MAX_V(1.0f + z, 1e-6f))", "sqrt(1.0f + z)"}}},
  };
}

}  // namespace multum
