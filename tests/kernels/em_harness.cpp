// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/em_harness.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include <glm/geometric.hpp>

#include "host/bakes/movmf/movmf_binning.h"
#include "host/bakes/movmf/movmf_em_step.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/lab/reference/planar_em.h"

namespace multum::testing {
namespace {

// Makes a window of planes of rows. The planes come from `bytes`, one whole plane after the other, or are filled with
// zeros.
RowWindow window_of(Device& device, int plane_count, std::size_t row_bytes, int rows, const void* bytes) {
  RowWindow window(device, plane_count, row_bytes, rows, "test");
  const std::size_t plane_bytes = row_bytes * static_cast<std::size_t>(rows);
  const auto copy = [&](int, int, const std::vector<unsigned char*>& planes) {
    for (std::size_t p = 0; p < planes.size(); ++p)
      std::memcpy(planes[p], static_cast<const unsigned char*>(bytes) + p * plane_bytes, plane_bytes);
  };
  window.move_to(0, rows, bytes == nullptr ? RowWindow::Fill() : copy);  // a new window holds zeros
  return window;
}

// Makes a window of all rows of a store, as the fit does.
RowWindow window_of(Device& device, const RowStore& store, const RowWindow::Fill& fill) {
  RowWindow window(device, 1, store.row_bytes(), store.row_count(), "test");
  window.move_to(0, store.row_count(), fill);
  return window;
}

MovmfSettings settings_of(const LevelFit& how, int lobe_count) {
  MovmfSettings settings;
  settings.representation = how.representation;
  settings.lobe_count = lobe_count;
  settings.iteration_count = settings.iteration_count_coarse = settings.iteration_count_top = how.iterations;
  settings.convergence_tolerance = how.convergence_tolerance;
  settings.alignment = how.alignment;
  settings.kappa_cap = how.kappa_cap;
  settings.kappa_cap_slope = how.kappa_cap_slope;
  return settings;
}

// Makes a schedule of this one level.
MipSchedule one_level_schedule(const NormalMap& map, const MovmfSettings& settings, const LevelFit& how) {
  MipSchedule schedule = make_mip_schedule(map.width, map.height, settings);
  std::erase_if(schedule.levels, [&](const LevelSchedule& level) { return level.level != how.level; });
  LevelSchedule& level = schedule.levels.at(0);
  MultumMovmfFit& fit = level.fit;
  fit.parent_width = mip_level_size(map.width, how.level + 1);
  fit.parent_height = mip_level_size(map.height, how.level + 1);
  level.method = how.method;
  fit.iteration_count = how.iterations;
  fit.parent_window_rows = fit.parent_height;
  if (how.method == FitMethod::kBinned) {
    fit.cell_side = kCellSideFew;
    fit.sample_capacity = fit.cell_side * fit.cell_side;
  }
  if (how.shortened) make_shortened(schedule);
  return schedule;
}

// Appends the initial lobe of a texel, which is the lobe `from` of the parent, and the prior that the parent gives.
void append_start(const MultumVmfLobe& from, double alignment, std::vector<reference::Lobe>& lobes,
                  reference::EmOptions& options) {
  const double a = static_cast<double>(from.amplitude);
  const glm::dvec3 mu(from.mean_x, from.mean_y, 0.0);
  lobes.push_back(
      {mu, std::clamp(0.5 / std::max(static_cast<double>(from.mean_z), 1e-6), 0.05, 1e6), std::max(a, 0.02)});
  options.prior.push_back(alignment * a * (mu + glm::dvec3(0.0, 0.0, 1.0)));
}

// Projects normals to points of the plane.
std::vector<reference::Sample> as_points(std::vector<reference::Sample> samples, bool shortened) {
  for (reference::Sample& s : samples) s.normal = reference::planar_sample(s.normal, shortened);
  return samples;
}

glm::dvec3 direction_of(const MultumVmfLobe& lobe) {
  const glm::dvec3 r(lobe.mean_x, lobe.mean_y, lobe.mean_z);
  return glm::length(r) > 1e-12 ? glm::normalize(r) : glm::dvec3(0.0, 0.0, 1.0);
}

}  // namespace

std::vector<MultumVmfLobe> fit_with_kernels(const NormalMap& map, const std::vector<MultumVmfLobe>& parent,
                                            int lobe_count, const LevelFit& how) {
  Device& device = test_device();
  device.set_shape(how.scalar ? LaunchShape::of_accelerator(device.info()) : LaunchShape::of(device.info()));
  const MovmfSettings settings = settings_of(how, lobe_count);
  const MipSchedule schedule = one_level_schedule(map, settings, how);
  const LevelSchedule& level = schedule.levels[0];
  const MultumMovmfFit& fit = level.fit;
  const std::size_t texels = static_cast<std::size_t>(fit.width) * static_cast<std::size_t>(fit.height);
  const std::size_t lobe_row = static_cast<std::size_t>(fit.width) * sizeof(MultumVmfLobe);
  // Neighbours with a lower colour rank are read as if they were already fitted, so the prior finds only zeros there.
  StepWindows windows;
  windows.lobes = window_of(device, lobe_count, lobe_row, fit.height, nullptr);
  windows.alignment_vectors = window_of(device, lobe_count, lobe_row, fit.height, nullptr);
  windows.parent = window_of(device, lobe_count, static_cast<std::size_t>(fit.parent_width) * sizeof(MultumVmfLobe),
                             fit.parent_height, parent.data());
  const PlaneStore planes = planes_of(map);
  MapWindows normals(device, planes, {}, map.height);
  normals.move_to(0, map.height);
  windows.map = &normals;
  const auto binned =
      bin_levels(device, planes, {}, schedule, settings.representation, how.bin_rows, nullptr, {}, nullptr);
  if (how.method == FitMethod::kBinned) {
    const BinnedLevel& from = binned.at(how.level);
    windows.binned = window_of(device, from.samples, fill_binned(from, from.samples, binned_bytes(fit)));
    windows.binned_counts = window_of(device, from.counts, fill_planes(from.counts));
  }
  std::vector<int> list(texels);
  std::iota(list.begin(), list.end(), 0);
  MovmfEmStep em_step(device, settings, schedule.weighted);
  em_step.run(level.method, fit, list, windows, nullptr);
  std::vector<MultumVmfLobe> result(static_cast<std::size_t>(lobe_count) * texels);
  device.read(windows.lobes.buffer(), result.data(), result.size() * sizeof(MultumVmfLobe));
  return result;
}

std::vector<reference::Sample> covered_samples(const NormalMap& map, int level, int x, int y) {
  const auto overlap = [](int index, int texel, int map_size, int level_size) {
    const double low = std::max<double>(index, static_cast<double>(texel) * map_size / level_size);
    const double high = std::min<double>(index + 1, static_cast<double>(texel + 1) * map_size / level_size);
    return std::max(0.0, high - low);
  };
  const int width = mip_level_size(map.width, level), height = mip_level_size(map.height, level);
  std::vector<reference::Sample> samples;
  for (int row = 0; row < map.height; ++row) {
    const double row_share = overlap(row, y, map.height, height);
    if (row_share < 1e-9) continue;
    for (int column = 0; column < map.width; ++column) {
      const double share = row_share * overlap(column, x, map.width, width);
      if (share < 1e-9) continue;
      const auto i = static_cast<std::size_t>(row * map.width + column);
      samples.push_back({glm::dvec3(map.x[i], map.y[i], map.z[i]), share});
    }
  }
  return samples;
}

std::vector<reference::Moments> fit_with_reference(const NormalMap& map, const std::vector<MultumVmfLobe>& parent,
                                                   int lobe_count, const LevelFit& how) {
  const int width = mip_level_size(map.width, how.level), height = mip_level_size(map.height, how.level);
  const int parent_width = mip_level_size(map.width, how.level + 1),
            parent_height = mip_level_size(map.height, how.level + 1);
  const auto texels = static_cast<std::size_t>(width * height);
  const bool gaussians = how.representation == Representation::kGmm;
  std::vector<reference::Moments> result(static_cast<std::size_t>(lobe_count) * texels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::vector<reference::Lobe> lobes;
      reference::EmOptions options{how.iterations,
                                   static_cast<double>(how.kappa_cap),
                                   static_cast<double>(how.kappa_cap_slope),
                                   {},
                                   how.shortened ? static_cast<double>(kCopiesShortened) : 1.0};
      for (int j = 0; j < lobe_count; ++j) {
        const int parent_texel = std::min(y / 2, parent_height - 1) * parent_width + std::min(x / 2, parent_width - 1);
        const MultumVmfLobe& from = parent[static_cast<std::size_t>(j * parent_width * parent_height + parent_texel)];
        if (gaussians) {
          append_start(from, static_cast<double>(how.alignment), lobes, options);
          continue;
        }
        const glm::dvec3 mu = direction_of(from);
        const double r = std::min(glm::length(glm::dvec3(from.mean_x, from.mean_y, from.mean_z)), 1.0 - 1e-6);
        lobes.push_back({mu, std::clamp(reference::kappa_of_mean_length(r) * 0.5, 0.05, 1e6),
                         std::max(static_cast<double>(from.amplitude), 0.02)});
        options.prior.push_back(static_cast<double>(how.alignment) * static_cast<double>(from.amplitude) * mu);
      }
      const std::vector<reference::Sample> samples = covered_samples(map, how.level, x, y);
      const std::vector<reference::Moments> moments =
          gaussians ? reference::fit_planar(as_points(samples, how.shortened), lobes, options)
                    : reference::fit(samples, lobes, options);
      for (int j = 0; j < lobe_count; ++j)
        result[static_cast<std::size_t>(j) * texels + static_cast<std::size_t>(y * width + x)] =
            moments[static_cast<std::size_t>(j)];
    }
  return result;
}

}  // namespace multum::testing
