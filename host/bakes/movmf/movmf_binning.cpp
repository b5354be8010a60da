// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/movmf_binning.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <vector>

#include "host/formats/asset/lobes/lobe_family.h"

namespace multum {
namespace {

constexpr int kChunkColumns = 256;  // approximate number of columns per work-item that fills its own cells
constexpr int kStripRows = 32;      // rows per work-item that adds to shared cells

constexpr std::size_t kAxisBytes = std::size_t{2} * MULTUM_AXIS_FLOATS * sizeof(float);
constexpr std::size_t kSampleBytes = std::size_t{MULTUM_CONDENSED_SAMPLE} * sizeof(float);
constexpr std::size_t kProbeBytes = std::size_t{2} * MULTUM_PROBE_COUNT * sizeof(float);

// Returns the largest number of texel rows that a band of `band_rows` map rows overlaps.
int rows_met(const MultumMovmfFit& fit, int band_rows) {
  return std::min(fit.height, (band_rows + fit.sample_rows - 1) / std::max(1, fit.sample_rows - 1) + 1);
}

std::size_t cell_bytes(const MultumMovmfFit& fit) {
  return static_cast<std::size_t>(fit.sample_capacity) * MULTUM_CELL_SUMS * sizeof(std::int64_t);
}

int chunk_count_of(const MultumMovmfFit& fit, const LaunchShape& shape) {
  return shape.atomic_cells ? 1 : (fit.sample_columns + kChunkColumns - 1) / kChunkColumns;
}

// Bins one level during a pass over the map. The object has buffers for the texel rows that the band overlaps. Row y is
// in slot y % slots.
class LevelBinner {
 public:
  LevelBinner(Device& device, const LevelSchedule& level, const KernelVariant& variant, int band_rows,
              std::size_t rgb_plane_count, const SpillPolicy& spill)
      : device_(device),
        fit_(level.fit),
        width_(static_cast<std::size_t>(level.fit.width)),
        chunk_count_(chunk_count_of(level.fit, device.shape())),
        axes_(level.fit.height, width_ * kAxisBytes, spill),
        row_bytes_(width_ * binned_bytes(level.fit)),
        result_{
            RowStore(level.fit.height, row_bytes_, spill), RowStore(level.fit.height, width_ * sizeof(int), spill), {}},
        slots_(static_cast<std::size_t>(rows_met(level.fit, band_rows))),
        host_(std::max(row_bytes_, width_ * kAxisBytes)),
        numbers_(width_) {
    const auto kernel = [&](const char* name) { return device.kernel("movmf_binning", name, variant); };
    const auto team_kernel = [&](const char* name) { return device.kernel("movmf_binning_team", name, variant); };
    probe_kernel_ = kernel("movmf_bin_probe");
    axes_kernel_ = kernel("movmf_bin_axes");
    cells_kernel_ = is_atomic() ? team_kernel("movmf_bin_add") : kernel("movmf_bin_cells");
    means_kernel_ = by_teams() ? team_kernel("movmf_bin_team_means") : kernel("movmf_bin_means");
    for (std::size_t t = 0; t < rgb_plane_count; ++t)
      result_.rgb_planes.emplace_back(level.fit.height, row_bytes_, spill);
    samples_ = device.make_buffer(row_bytes_, "binned normals");
    counts_ = device.make_buffer(width_ * sizeof(int), "numbers of binned normals");
    for (Slot& slot : slots_) {
      slot.axes = device.make_buffer(width_ * kAxisBytes, "axes of cells");
      slot.probes = device.make_buffer(width_ * kProbeBytes, "probes of normals");
    }
  }

  // In the first pass, collects normals for the axes from the rows in `normals`.
  void probe(const MapWindow& normals) {
    for_each_row(normals, [&](int y, Slot& slot, bool, bool ends) {
      probe_kernel_.launch({width_ * MULTUM_PROBE_SIDE}, normals[0], normals[1], normals[2], slot.probes, fit_, y);
      if (!ends) return;
      axes_kernel_.launch({2 * width_}, slot.probes, slot.axes, fit_, y);
      device_.read(slot.axes, host_.data(), width_ * kAxisBytes);
      axes_.write(y, 1, host_.data());
    });
  }

  // Frees the probes between the passes.
  void begin_cells() {
    for (Slot& slot : slots_) {
      slot.probes = DeviceBuffer();
      slot.cells = make_cells();
      for (std::size_t t = 0; t < result_.rgb_planes.size(); ++t) slot.rgb_cells.push_back(make_cells());
    }
  }

  // In the second pass, fills the cells. `features` must hold the same rows as `normals`.
  void add(const MapWindow& normals, const std::vector<MapWindow>& features) {
    for_each_row(normals, [&](int y, Slot& slot, bool begins, bool ends) {
      if (begins) {
        axes_.read(y, 1, host_.data());
        device_.write(slot.axes, host_.data(), width_ * kAxisBytes);
        device_.fill_zero(slot.cells);
        for (DeviceBuffer& cells : slot.rgb_cells) device_.fill_zero(cells);
      }
      add_to(slot.cells, slot, y, normals, normals, true);
      for (std::size_t t = 0; t < features.size(); ++t) add_to(slot.rgb_cells[t], slot, y, normals, features[t], false);
      if (!ends) return;
      store_means(slot.cells, y, result_.samples, true);
      for (std::size_t t = 0; t < features.size(); ++t) store_means(slot.rgb_cells[t], y, result_.rgb_planes[t], false);
    });
  }

  BinnedLevel take() { return std::move(result_); }

 private:
  struct Slot {
    DeviceBuffer probes, axes, cells;
    std::vector<DeviceBuffer> rgb_cells;
  };

  bool is_atomic() const { return device_.shape().atomic_cells; }
  bool by_teams() const { return device_.shape().has_teams(); }

  DeviceBuffer make_cells() {
    return device_.make_buffer(width_ * static_cast<std::size_t>(chunk_count_) * cell_bytes(fit_), "cells of normals");
  }

  // Calls body(y, slot, begins, ends) for each row of texels that overlaps the window. `begins` and `ends` state
  // whether the window contains the first and the last map row of the texels.
  template <typename Body>
  void for_each_row(const MapWindow& normals, const Body& body) {
    const int first = normals.first_row(), end = first + normals.row_count();
    fit_.map_first_row = first;
    fit_.map_window_rows = normals.row_count();
    int y = static_cast<int>(std::int64_t{first} * fit_.height / fit_.map_height);
    for (; y < fit_.height && first_covered_row(fit_, y) < end; ++y) {
      // The first y was rounded down, so a row of texels may end above the band. Such a row is already finished.
      if (last_covered_row(fit_, y) <= first) continue;
      body(y, slots_[static_cast<std::size_t>(y) % slots_.size()], first_covered_row(fit_, y) >= first,
           last_covered_row(fit_, y) <= end);
    }
  }

  void add_to(DeviceBuffer& cells, const Slot& slot, int y, const MapWindow& normals, const MapWindow& values,
              bool are_normals) {
    if (is_atomic()) {
      const int strips = (fit_.map_window_rows + kStripRows - 1) / kStripRows;
      const std::size_t columns = width_ * static_cast<std::size_t>(fit_.sample_columns);
      cells_kernel_.launch({columns * static_cast<std::size_t>(strips)}, normals[0], normals[1], normals[2], values[0],
                           values[1], values[2], slot.axes, cells, fit_, y, kStripRows, strips, are_normals ? 1 : 0);
      return;
    }
    cells_kernel_.launch({width_ * static_cast<std::size_t>(chunk_count_)}, normals[0], normals[1], normals[2],
                         values[0], values[1], values[2], slot.axes, cells, fit_, y, chunk_count_, are_normals ? 1 : 0);
  }

  void store_means(const DeviceBuffer& cells, int y, RowStore& to, bool are_normals) {
    means_kernel_.launch(by_teams() ? Kernel::WorkSize{width_ * MULTUM_TEAM, MULTUM_TEAM} : Kernel::WorkSize{width_},
                         cells, samples_, counts_, fit_.width, chunk_count_, fit_.sample_capacity, are_normals ? 1 : 0);
    device_.read(counts_, numbers_.data(), width_ * sizeof(int));
    result_.counts.write(y, 1, numbers_.data());
    std::size_t end = 0;
    device_.read_ranges({{&samples_, 0, row_bytes_}}, [&](const Device::Bytes& samples) {
      for (std::size_t x = 0; x < width_; ++x) {
        const std::size_t bytes = static_cast<std::size_t>(numbers_[x]) * kSampleBytes;
        std::memcpy(host_.data() + end, samples[0] + x * binned_bytes(fit_), bytes);
        end += bytes;
      }
    });
    to.write_beginning(y, host_.data(), end);
  }

  Device& device_;
  MultumMovmfFit fit_;
  const std::size_t width_;
  const int chunk_count_;
  RowStore axes_;
  const std::size_t row_bytes_;  // bytes of a row of samples
  BinnedLevel result_;
  std::vector<Slot> slots_;
  std::vector<unsigned char> host_;
  std::vector<int> numbers_;
  Kernel probe_kernel_, axes_kernel_, cells_kernel_, means_kernel_;
  DeviceBuffer samples_, counts_;
};

}  // namespace

std::size_t binned_bytes(const MultumMovmfFit& fit) {
  return static_cast<std::size_t>(fit.sample_capacity) * kSampleBytes;
}

RowWindow::Fill fill_binned(const BinnedLevel& level, const RowStore& samples, std::size_t texel_bytes) {
  return [&level, &samples, texel_bytes](int row, int count, const std::vector<unsigned char*>& planes) {
    std::vector<int> numbers(level.counts.row_bytes() / sizeof(int));
    std::vector<unsigned char> packed(samples.row_bytes());
    for_each_piece(row, count, samples.row_count(), [&](int first, int piece, int at) {
      unsigned char* to = planes[0] + static_cast<std::size_t>(at) * samples.row_bytes();
      for (int r = first; r < first + piece; ++r) {
        level.counts.read(r, 1, numbers.data());
        const auto total = static_cast<std::size_t>(std::accumulate(numbers.begin(), numbers.end(), std::int64_t{0}));
        samples.read_beginning(r, packed.data(), total * kSampleBytes);
        const unsigned char* from = packed.data();
        for (const int number : numbers) {
          const std::size_t bytes = static_cast<std::size_t>(number) * kSampleBytes;
          std::memcpy(to, from, bytes);
          from += bytes;
          to += texel_bytes;
        }
      }
    });
  };
}

namespace {

KernelVariant binning_variant(const MipSchedule& schedule, Representation representation) {
  return {1, 1, schedule.weighted, lobe_family(representation).is_planar};
}

}  // namespace

std::vector<ProgramChoice> binning_programs(const MipSchedule& schedule, Representation representation,
                                            const LaunchShape& shape) {
  if (!schedule.uses(FitMethod::kBinned)) return {};
  const KernelVariant variant = binning_variant(schedule, representation);
  std::vector<ProgramChoice> programs = {{"movmf_binning", variant}};
  if (shape.atomic_cells || shape.has_teams()) programs.push_back({"movmf_binning_team", variant});
  return programs;
}

std::map<int, BinnedLevel> bin_levels(Device& device, const PlaneStore& normals,
                                      const std::vector<const PlaneStore*>& features, const MipSchedule& schedule,
                                      Representation representation, int band_rows, MapWindows* on_device,
                                      const SpillPolicy& spill, Progress* progress) {
  const KernelVariant variant = binning_variant(schedule, representation);
  std::map<int, LevelBinner> levels;
  for (const LevelSchedule& level : schedule.levels)
    if (level.method == FitMethod::kBinned)
      levels.try_emplace(level.level, device, level, variant, band_rows, features.size(), spill);
  std::map<int, BinnedLevel> binned;
  if (levels.empty()) return binned;

  band_rows = std::min(band_rows, normals.height());
  std::optional<MapWindows> bands;
  if (on_device == nullptr || band_rows < normals.height()) bands.emplace(device, normals, features, band_rows);
  MapWindows& map = bands ? *bands : *on_device;
  const auto for_each_band = [&](const auto& body) {
    if (bands) map.normals.move_to(0, 0);  // windows can only slide down
    for (int row = 0; row < normals.height(); row += band_rows) {
      map.normals.move_to(row, std::min(band_rows, normals.height() - row));
      body();
      device.finish();
      progress_advance(progress, 0);  // lets the caller cancel
    }
  };
  for_each_band([&] {
    for (auto& entry : levels) entry.second.probe(map.normals);
  });
  for (auto& entry : levels) entry.second.begin_cells();
  for_each_band([&] {
    for (MapWindow& rgb_plane : map.rgb_planes) rgb_plane.move_to(map.normals.first_row(), map.normals.row_count());
    for (auto& entry : levels) entry.second.add(map.normals, map.rgb_planes);
  });
  for (auto& entry : levels) binned.try_emplace(entry.first, entry.second.take());
  return binned;
}

std::uint64_t binning_bytes(const MipSchedule& schedule, int band_rows, int rgb_plane_count, const LaunchShape& shape) {
  const auto windows = static_cast<std::uint64_t>(1 + rgb_plane_count);
  std::uint64_t bytes = 0;
  for (const LevelSchedule& level : schedule.levels) {
    if (level.method != FitMethod::kBinned) continue;
    const MultumMovmfFit& fit = level.fit;
    const std::uint64_t cells = static_cast<std::uint64_t>(chunk_count_of(fit, shape)) * cell_bytes(fit) * windows;
    bytes += static_cast<std::uint64_t>(fit.width) *
             (static_cast<std::uint64_t>(rows_met(fit, band_rows)) * (cells + kAxisBytes) + 2 * binned_bytes(fit));
  }
  const int map_width = schedule.levels.empty() ? 0 : schedule.levels[0].fit.map_width;
  return bytes +
         static_cast<std::uint64_t>(band_rows) * static_cast<std::uint64_t>(map_width) * sizeof(float) * 3 * windows;
}

}  // namespace multum
