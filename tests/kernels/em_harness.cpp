// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/em_harness.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glm/geometric.hpp>

#include "host/asset/movmf_mipmap.h"
#include "host/bake/mip_schedule.h"

namespace multum::testing {
namespace {

constexpr float kPoison = -12345.0f;

template <typename Value>
DeviceBuffer upload(Device& device, const std::vector<Value>& values) {
  DeviceBuffer buffer = device.make_buffer(values.size() * sizeof(Value), "test");
  device.write(buffer, values.data(), values.size() * sizeof(Value));
  return buffer;
}

DeviceBuffer upload_plane(Device& device, std::vector<float> plane) {
  plane.resize(plane.size() + MULTUM_GROUP, 0.0f);
  return upload(device, plane);
}

LevelSchedule level_schedule(const NormalMap& map, const LevelFit& how, bool* weighted) {
  MovmfSettings settings;
  settings.iteration_count = settings.iteration_count_top = how.iterations;
  settings.alignment = how.alignment;
  settings.kappa_cap = how.kappa_cap;
  settings.kappa_cap_slope = how.kappa_cap_slope;
  const MipSchedule schedule = make_mip_schedule(map.width, map.height, settings);
  *weighted = schedule.weighted;
  for (const LevelSchedule& level : schedule.levels)
    if (level.level == how.level) return level;
  std::abort();
}

glm::dvec3 direction_of(const MultumVmfLobe& lobe) {
  const glm::dvec3 r(lobe.mean_x, lobe.mean_y, lobe.mean_z);
  return glm::length(r) > 1e-12 ? glm::normalize(r) : glm::dvec3(0.0, 0.0, 1.0);
}

}  // namespace

Device& test_device() {
  // Never closed: a simulator preloaded into the process (oclgrind) is gone before the program's own statics are.
  static Device& device = *new Device(Device::open(""));
  return device;
}

std::vector<MultumVmfLobe> fit_with_kernels(const NormalMap& map, const std::vector<MultumVmfLobe>& parent,
                                            int lobe_count, const LevelFit& how) {
  Device& device = test_device();
  bool weighted = false;
  const LevelSchedule level = level_schedule(map, how, &weighted);
  MultumMovmfFit fit = level.fit;
  fit.parent_width = mip_level_size(map.width, how.level + 1);
  fit.parent_height = mip_level_size(map.height, how.level + 1);
  const int texels = fit.width * fit.height;
  // One launch of every texel: neighbours of lower colour rank would be read as done, so the prior sees only zeros
  // there.
  std::vector<int> list(static_cast<std::size_t>(texels));
  for (int i = 0; i < texels; ++i) list[static_cast<std::size_t>(i)] = i;
  while (list.size() % MULTUM_GROUP != 0) list.push_back(-1);
  fit.list_offset = 0;
  fit.slot_count = static_cast<int>(list.size());
  const auto slots = list.size(), lobes = static_cast<std::size_t>(lobe_count);

  const KernelVariant scalar{lobe_count, 1, weighted};
  KernelVariant fast = scalar;
  fast.vector_width = how.scalar ? 1 : 16;
  const DeviceBuffer x = upload_plane(device, map.x), y = upload_plane(device, map.y), z = upload_plane(device, map.z);
  const DeviceBuffer list_buffer = upload(device, list), parent_buffer = upload(device, parent);
  std::vector<MultumVmfLobe> result(lobes * static_cast<std::size_t>(texels), MultumVmfLobe{0, 0, 0, 0});
  DeviceBuffer level_buffer = upload(device, result);
  const DeviceBuffer start = upload(device, std::vector<float>(slots * lobes * MULTUM_START_PLANES, kPoison));
  device.kernel("movmf_start", "movmf_start", scalar)
      .launch({slots * lobes}, parent_buffer, level_buffer, list_buffer, start, fit, 0.5f, 0.02f);
  // Now poison what must be written.
  for (MultumVmfLobe& lobe : result) lobe = {kPoison, kPoison, kPoison, kPoison};
  device.write(level_buffer, result.data(), result.size() * sizeof(MultumVmfLobe));
  if (how.force_chunked || level.chunked) {
    const std::size_t chunks = slots * static_cast<std::size_t>(fit.chunk_count);
    const DeviceBuffer partial = upload(device, std::vector<float>(chunks * lobes * 5, kPoison));
    Kernel em = device.kernel("movmf_em_chunks", "movmf_em_partial", fast);
    Kernel mstep = device.kernel("movmf_em_mstep", "movmf_em_mstep", scalar);
    for (int i = 0; i < fit.iteration_count; ++i) {
      em.launch(how.scalar ? Kernel::WorkSize{chunks * MULTUM_GROUP, MULTUM_GROUP} : Kernel::WorkSize{chunks, 1}, x, y,
                z, start, list_buffer, partial, fit);
      mstep.launch({slots * lobes}, partial, start, list_buffer, level_buffer, fit, i);
    }
  } else {
    const std::size_t planes = weighted ? 4 : 3;
    const auto samples = static_cast<std::size_t>(fit.sample_columns) * static_cast<std::size_t>(fit.sample_rows);
    const DeviceBuffer packed = upload(device, std::vector<float>(slots * samples * planes, kPoison));
    device.kernel("movmf_start", "movmf_pack", scalar)
        .launch({slots / MULTUM_GROUP * static_cast<std::size_t>(fit.sample_rows)}, x, y, z, list_buffer, packed, fit);
    device.kernel("movmf_em_texels", "movmf_em_texels", fast)
        .launch({how.scalar ? slots : slots / MULTUM_GROUP}, packed, start, list_buffer, level_buffer, fit);
  }
  device.read(level_buffer, result.data(), result.size() * sizeof(MultumVmfLobe));
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
  std::vector<reference::Moments> result(static_cast<std::size_t>(lobe_count) * texels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::vector<reference::Lobe> lobes;
      reference::EmOptions options{
          how.iterations, static_cast<double>(how.kappa_cap), static_cast<double>(how.kappa_cap_slope), {}};
      for (int j = 0; j < lobe_count; ++j) {
        const int parent_texel = std::min(y / 2, parent_height - 1) * parent_width + std::min(x / 2, parent_width - 1);
        const MultumVmfLobe& from = parent[static_cast<std::size_t>(j * parent_width * parent_height + parent_texel)];
        const glm::dvec3 mu = direction_of(from);
        const double r = std::min(glm::length(glm::dvec3(from.mean_x, from.mean_y, from.mean_z)), 1.0 - 1e-6);
        lobes.push_back({mu, std::clamp(reference::kappa_of_mean_length(r) * 0.5, 0.05, 1e6),
                         std::max(static_cast<double>(from.amplitude), 0.02)});
        options.prior.push_back(static_cast<double>(how.alignment) * static_cast<double>(from.amplitude) * mu);
      }
      const std::vector<reference::Moments> moments =
          reference::fit(covered_samples(map, how.level, x, y), lobes, options);
      for (int j = 0; j < lobe_count; ++j)
        result[static_cast<std::size_t>(j) * texels + static_cast<std::size_t>(y * width + x)] =
            moments[static_cast<std::size_t>(j)];
    }
  return result;
}

}  // namespace multum::testing
