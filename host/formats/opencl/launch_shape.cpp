// SPDX-License-Identifier: Apache-2.0
#include "host/formats/opencl/launch_shape.h"

#include <algorithm>

#include "kernels/shared/movmf_fit.h"

namespace multum {

LaunchShape LaunchShape::of(const DeviceInfo& info) {
  if (!info.is_cpu) return of_accelerator(info);
  LaunchShape shape{};
  shape.vector_width = 16;
  shape.local_size = 1;
  shape.pack_parts = 1;
  shape.strip_texels = 64;
  shape.strip_local_size = 4;
  return shape;
}

bool LaunchShape::fits_by_teams(std::size_t texels, int sample_capacity) const {
  return texels <= team_texels_max && sample_capacity >= MULTUM_TEAM;
}

LaunchShape LaunchShape::of_accelerator(const DeviceInfo& info) {
  LaunchShape shape{};
  // A compute unit holds about 2048 work-items. With fewer texels than a quarter of that number, teams are faster.
  constexpr std::size_t kTexelsAComputeUnit = 512;
  shape.vector_width = 1;
  shape.local_size = std::min<std::size_t>(64, static_cast<std::size_t>(std::max(1, info.work_group_max)));
  const bool has_room = info.work_group_max >= 64 && info.local_bytes >= (16u << 10);
  shape.team_texels_max = has_room ? kTexelsAComputeUnit * static_cast<std::size_t>(info.compute_units) : 0;
  shape.pack_parts = 256;
  shape.atomic_cells = info.has_atomic_longs;
  shape.strip_texels = 1;
  shape.strip_local_size = shape.local_size;
  shape.staging_bytes = std::size_t{32} << 20;
  shape.window_bytes_max = std::min(info.memory_bytes / 2, info.buffer_bytes_max);
  shape.window_bytes_useful = info.memory_bytes / 8;
  return shape;
}

}  // namespace multum
