// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/bake_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr int kBandRows[] = {4096, 2048, 1024, 512, 256, 192, 128, 96, 64, 48, 32, 24, 16, 12, 8, 6, 4, 2, 1};
constexpr int kBandRowsWanted = 8;  // with fewer rows, many threads have too little work, so more memory is used

// The memory for windows, and whether the device or the job limits it.
struct WindowMemory {
  std::uint64_t bytes;
  bool on_device;
};

// The largest lack of memory that was found, so that one message states all that is needed.
class MemoryLack {
 public:
  void note(const WindowMemory& found, std::uint64_t wanted, const std::string& what) {
    if (wanted <= found.bytes || (lack_ > 0 && wanted - found.bytes <= lack_)) return;
    lack_ = wanted - found.bytes;
    found_ = found;
    what_ = what;
  }

  // Throws Error if memory is lacking.
  void refuse() const {
    if (lack_ == 0) return;
    const auto mebibytes = [](std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); };
    const std::string missing =
        fmt::format("leaves {:.1f} MiB for windows and buffers, expected at least {:.1f} MiB for {}",
                    mebibytes(found_.bytes), mebibytes(found_.bytes + lack_), what_);
    if (found_.on_device) throw Error(ErrorCode::kEnvironment, "the device " + missing);
    throw Error(ErrorCode::kUsage,
                fmt::format("--memory {}; add at least {} MiB to --memory", missing, (lack_ + (1 << 20) - 1) >> 20));
  }

 private:
  std::uint64_t lack_ = 0;
  WindowMemory found_{};
  std::string what_;
};

// Chooses as many rows as fit into the useful memory. If fewer than kBandRowsWanted rows fit, chooses up to
// kBandRowsWanted rows within the memory limit. Returns 1 if not even one row fits, and notes the lack.
template <typename BytesOf>
int choose_rows(int rows_max, const WindowMemory& memory, std::uint64_t useful_bytes, const BytesOf& bytes_of,
                const std::string& what, MemoryLack& lack) {
  const std::uint64_t useful = std::min(memory.bytes, useful_bytes);
  for (int rows : kBandRows) {
    const std::uint64_t bytes = bytes_of(std::min(rows, rows_max));
    if (bytes <= useful || (rows <= kBandRowsWanted && bytes <= memory.bytes)) return std::min(rows, rows_max);
  }
  lack.note(memory, bytes_of(1), what);
  return 1;
}

}  // namespace

BakePlan make_bake_plan(const MipSchedule& schedule, const MovmfSettings& settings, const MapInputs& map,
                        const LaunchShape& shape) {
  BakePlan plan;
  MULTUM_CHECK(map.writer_bytes <= map.memory_bytes);
  const bool on_device = shape.window_bytes_max > 0;
  const int rgb_plane_count = map.features.rgb_plane_count();
  const std::uint64_t memory_bytes = on_device ? shape.window_bytes_max : map.memory_bytes - map.writer_bytes;
  // During binning, the writer holds no memory yet.
  const WindowMemory fitting{memory_bytes, on_device}, binning{on_device ? memory_bytes : map.memory_bytes, on_device};
  plan.memory_bytes = memory_bytes;
  const int map_width = schedule.levels.empty() ? 1 : schedule.levels[0].fit.map_width;
  const std::uint64_t useful =
      on_device ? shape.window_bytes_useful
                : std::max(kUsefulWindowBytes, static_cast<std::uint64_t>(map_width) * kUsefulBytesAColumn);
  plan.spill_bytes = map.spill.memory_bytes;
  MemoryLack lack;
  for (const LevelSchedule& level : schedule.levels) {
    const int height = level.fit.height, map_height = level.fit.map_height;
    BandPlan& band = plan.levels[level.level];
    if (level.method == FitMethod::kChunks) {
      // The whole level and as much of the map as possible are in memory. Each band of the map is read once per
      // iteration.
      const auto bytes_of = [&](int rows) { return fit_level_bytes(level, settings, rgb_plane_count, {height, rows}); };
      band = {height, map_height};
      while (band.map_band_rows > 1 && bytes_of(band.map_band_rows) > memory_bytes) band.map_band_rows /= 2;
      lack.note(fitting, bytes_of(band.map_band_rows),
                fmt::format("all texels of level {} at the same time (--coarse-normals all)", level.level));
    } else {
      const auto bytes_of = [&](int rows) {
        return fit_level_bytes(level, settings, rgb_plane_count, {rows, map_height});
      };
      band = {choose_rows(height, fitting, useful, bytes_of, fmt::format("a row of level {}", level.level), lack),
              map_height};
    }
  }
  const int map_height = schedule.levels.empty() ? 1 : schedule.levels[0].fit.map_height;
  plan.bin_rows = choose_rows(
      map_height, binning, useful, [&](int rows) { return binning_bytes(schedule, rows, rgb_plane_count, shape); },
      "binning a row of normals", lack);
  lack.refuse();
  return plan;
}

std::string BakePlan::to_text(const MipSchedule& schedule, const MovmfSettings& settings, int rgb_plane_count) const {
  std::string text = fmt::format(
      "plan: windows and buffers take at most {} MiB; levels larger than {} MiB are kept in scratch files\n",
      memory_bytes >> 20, spill_bytes >> 20);
  for (const LevelSchedule& level : schedule.levels) {
    const BandPlan& band = levels.at(level.level);
    const bool whole = band.band_rows >= level.fit.height;
    const char* method = level.method == FitMethod::kTexels   ? "all normals"
                         : level.method == FitMethod::kChoice ? "each normal assigned to a lobe"
                         : level.method == FitMethod::kBinned ? "binned normals"
                                                              : "all normals, one band of the map at a time";
    text += fmt::format("  level {}: {} x {}, {}, {}, {:.1f} MiB\n", level.level, level.fit.width, level.fit.height,
                        method, whole ? "at once" : fmt::format("{} rows at a time", band.band_rows),
                        static_cast<double>(fit_level_bytes(level, settings, rgb_plane_count, band)) / (1 << 20));
  }
  return text;
}

}  // namespace multum
