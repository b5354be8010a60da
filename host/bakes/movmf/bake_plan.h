// SPDX-License-Identifier: Apache-2.0
// Plans how a bake fits into memory: the bands of rows in which each level is fitted, and what stays in memory between
// levels. The plan changes no byte of the result.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/movmf/movmf_level_fit.h"
#include "host/bakes/pyramid/row_store.h"
#include "host/formats/opencl/launch_shape.h"

namespace multum {

struct BakePlan {
  std::uint64_t memory_bytes = 0;  // what the windows and buffers of a level may take
  std::map<int, BandPlan> levels;  // by level, of those that are fitted
  int bin_rows = 1;                // of the map, a band while coarse texels are binned
  SpillPolicy spill;               // of what one level leaves for the next

  /// For people: a line each for the whole and for every level.
  std::string to_text(const MipSchedule& schedule, const MovmfSettings& settings, int rgb_plane_count) const;
};

/// Memory that windows use when they may: larger bands are no faster.
constexpr std::uint64_t kUsefulWindowBytes = std::uint64_t{64} << 20;
constexpr std::uint64_t kUsefulBytesAColumn = std::uint64_t{12} << 10;  // of a map that is wider

struct PlanMemory {
  std::uint64_t bytes;             // for windows and buffers
  std::uint64_t writer_bytes = 0;  // of these, what others hold while levels are fitted; binning comes before
};

/// `shape`: a device with memory of its own has the windows there, and `memory` is not asked. Throws Error(kUsage) that
/// names --memory, or Error(kEnvironment) that names the device, when not even a row of some level fits.
BakePlan make_bake_plan(const MipSchedule& schedule, const MovmfSettings& settings, int rgb_plane_count,
                        const PlanMemory& memory, const SpillPolicy& spill, const LaunchShape& shape);

}  // namespace multum
