// SPDX-License-Identifier: Apache-2.0
// Plans the use of memory by a bake. The plan states the bands of rows in which each level is fitted, and the data that
// stays in memory between levels. The plan does not change a single byte of the result.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/movmf/movmf_level_fit.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/opencl/launch_shape.h"

namespace multum {

struct BakePlan {
  std::uint64_t memory_bytes = 0;  // limit for the windows and buffers of a level
  std::map<int, BandPlan> levels;  // [level], for fitted levels
  int bin_rows = 1;                // rows of the map per band for binning coarse texels
  std::int64_t spill_bytes = 0;    // larger outputs for the next level are written to scratch files

  /// Describes the plan, in one line for the whole fit and one line per level.
  std::string to_text(const MipSchedule& schedule, const MovmfSettings& settings, int rgb_plane_count) const;
};

/// The memory that windows use if it is available. Larger bands would not be faster.
constexpr std::uint64_t kUsefulWindowBytes = std::uint64_t{64} << 20;
constexpr std::uint64_t kUsefulBytesAColumn = std::uint64_t{12} << 10;  // useful bytes per column of wider maps

/// `shape` describes the device. If the device has its own memory, windows are in this memory, and the map's
/// memory_bytes are ignored. If not even one row of a level fits, throws Error(kUsage) that names --memory, or
/// Error(kEnvironment) that names the device.
BakePlan make_bake_plan(const MipSchedule& schedule, const MovmfSettings& settings, const MapInputs& map,
                        const LaunchShape& shape);

}  // namespace multum
