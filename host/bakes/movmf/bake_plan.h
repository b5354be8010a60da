// SPDX-License-Identifier: Apache-2.0
// Plans how a bake fits into memory: the bands of rows in which each level is fitted, and what stays in memory between
// levels. The plan changes no byte of the result.
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
  std::uint64_t memory_bytes = 0;  // what the windows and buffers of a level may take
  std::map<int, BandPlan> levels;  // by level, of those that are fitted
  int bin_rows = 1;                // of the map, a band while coarse texels are binned
  std::int64_t spill_bytes = 0;    // of what one level leaves for the next, larger ones go to scratch files

  /// For people: a line each for the whole and for every level.
  std::string to_text(const MipSchedule& schedule, const MovmfSettings& settings, int rgb_plane_count) const;
};

/// Memory that windows use when they may: larger bands are no faster.
constexpr std::uint64_t kUsefulWindowBytes = std::uint64_t{64} << 20;
constexpr std::uint64_t kUsefulBytesAColumn = std::uint64_t{12} << 10;  // of a map that is wider

/// `shape`: a device with memory of its own has the windows there, and the map's memory_bytes are not asked. Throws
/// Error(kUsage) that names --memory, or Error(kEnvironment) that names the device, when not even a row of some level
/// fits.
BakePlan make_bake_plan(const MipSchedule& schedule, const MovmfSettings& settings, const MapInputs& map,
                        const LaunchShape& shape);

}  // namespace multum
