// SPDX-License-Identifier: Apache-2.0
#include "host/bake/average_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "host/bake/row_blocks.h"
#include "host/base/error.h"

namespace multum {
namespace {

// More makes nothing faster. Averaging a map of 4096 x 4096 on 2 cores of an AMD EPYC takes 3.6 s in bands of 16
// MiB, 3.9 s in bands of 64 MiB and 4.5 s in bands of 2 MiB (PoCL 3.1, medians of three, beside other work).
constexpr std::uint64_t kUsefulBandBytes = std::uint64_t{16} << 20;
constexpr std::size_t kMapPlanes = std::tuple_size_v<AveragedPlanes::MapPlanes>;

std::size_t size_of(int count) { return static_cast<std::size_t>(count); }

// The columns of all levels that are averaged, and what each takes of a row.
struct Columns {
  std::vector<MultumAverageLevel> levels;
  std::vector<int> numbers;  // of these levels
  std::vector<int> tap_begin;
  std::vector<MultumAverageTap> taps;
};

Columns make_columns(const RowBlocks& blocks, int map_width, int map_height, int first_level) {
  Columns columns;
  std::vector<RowBlocks::Tap> taps;
  for (int l = std::max(1, first_level); l < mip_level_count(map_width, map_height); ++l) {
    MultumAverageLevel level{};
    level.width = mip_level_size(map_width, l);
    level.height = mip_level_size(map_height, l);
    level.first_column = static_cast<int>(columns.tap_begin.size());
    level.share = static_cast<float>(static_cast<double>(level.width) * level.height /
                                     (static_cast<double>(map_width) * map_height));
    for (int x = 0; x < level.width; ++x) {
      columns.tap_begin.push_back(static_cast<int>(columns.taps.size()));
      taps.clear();
      blocks.append_taps(level.width, x, taps);
      for (const RowBlocks::Tap& tap : taps)
        columns.taps.push_back({static_cast<int>(tap.node), static_cast<float>(tap.weight)});
    }
    columns.levels.push_back(level);
    columns.numbers.push_back(l);
  }
  columns.tap_begin.push_back(static_cast<int>(columns.taps.size()));
  return columns;
}

class AveragePass {
 public:
  AveragePass(Device& device, const AverageInputs& inputs, AveragedPlanes& planes)
      : device_(device),
        inputs_(inputs),
        planes_(planes),
        width_(inputs.normals->width()),
        height_(inputs.normals->height()),
        plane_count_(planes.plane_count() + (inputs.albedo != nullptr ? 3 : 0)),
        blocks_(width_),
        columns_(make_columns(blocks_, width_, height_, inputs.first_level)),
        band_rows_(choose_band_rows()) {
    make_buffers();
    sum_blocks_ = device.kernel("plane_averages", "average_blocks", {1, 1, false});
    sum_levels_ = device.kernel("plane_averages", "average_levels", {1, 1, false});
  }

  std::string plan_text() const {
    return fmt::format("{} of {} x {}: one pass in bands of {} rows, {:.1f} MiB of buffers\n", planes_.name(), width_,
                       height_, band_rows_,
                       static_cast<double>(fixed_bytes() + size_of(band_rows_) * row_bytes()) / (1u << 20));
  }

  void run(Progress* progress) {
    progress_stage(progress, "average");
    for (int row = 0; row < height_; row += band_rows_) {
      const int rows = std::min(band_rows_, height_ - row);
      read_band(row, rows);
      average(row, rows);
      hand_over(row, rows);
      progress_advance(progress, static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(width_));
    }
  }

 private:
  // Nodes of a row apart: rounded up, and not at a distance of a power of two, which would share cache lines' places.
  int row_length() const { return static_cast<int>((blocks_.node_count() + 15) / 16 * 16 + 16); }
  int column_count() const { return static_cast<int>(columns_.tap_begin.size()) - 1; }
  bool has_colours() const { return inputs_.albedo != nullptr; }

  // The rows of a level that `rows` finest rows finish, at most.
  int finished_max(const MultumAverageLevel& level, int rows) const {
    return static_cast<int>(std::int64_t{rows} * level.height / height_) + 1;
  }
  // What a row more in the bands takes: map planes, nodes, what comes of them, and rows that wait to be written.
  std::uint64_t row_bytes() const {
    const std::size_t map_planes = kMapPlanes * (has_colours() ? 2 : 1);
    const std::size_t values = map_planes * size_of(width_) + size_of(plane_count_) * size_of(row_length()) +
                               3 * size_of(plane_count_ + 1) * size_of(width_);
    return values * sizeof(float);
  }
  std::uint64_t fixed_bytes() const {
    const std::size_t columns = size_of(column_count()), planes = size_of(plane_count_);
    // A row of every level whatever the band's height, twice: as averages and as rows that are handed over.
    return columns * planes * 4 * sizeof(float) + columns * sizeof(int) +
           columns_.taps.size() * sizeof(MultumAverageTap);
  }
  int choose_band_rows() const {
    if (fixed_bytes() + row_bytes() > inputs_.memory_bytes)
      throw Error(ErrorCode::kUsage,
                  fmt::format("--memory leaves {} KiB for buffers, expected at least {} KiB: a row of a map of {} x {}",
                              inputs_.memory_bytes >> 10, ((fixed_bytes() + row_bytes()) >> 10) + 1, width_, height_));
    const std::uint64_t bytes = std::min(kUsefulBandBytes, inputs_.memory_bytes - fixed_bytes());
    return static_cast<int>(std::clamp<std::uint64_t>(bytes / row_bytes(), 1, static_cast<std::uint64_t>(height_)));
  }

  void make_buffers() {
    const std::size_t row = size_of(width_) * sizeof(float) * size_of(band_rows_);
    for (DeviceBuffer& plane : normals_) plane = device_.make_buffer(row, "normals");
    if (has_colours())
      for (DeviceBuffer& plane : colours_) plane = device_.make_buffer(row, "colours");
    nodes_ = device_.make_buffer(size_of(plane_count_) * size_of(band_rows_) * size_of(row_length()) * sizeof(float),
                                 "nodes of rows");
    std::size_t values = 1;
    for (const MultumAverageLevel& level : columns_.levels)
      values += size_of(plane_count_) * size_of(finished_max(level, band_rows_)) * size_of(level.width);
    averages_ = device_.make_buffer(values * sizeof(float), "averages");
    sums_ = device_.make_buffer(
        std::max<std::size_t>(1, size_of(plane_count_) * size_of(column_count())) * 2 * sizeof(float),
        "sums of columns");
    device_.fill_zero(sums_);
    if (columns_.levels.empty()) return;
    tap_begin_ = device_.wrap_buffer(columns_.tap_begin.data(), columns_.tap_begin.size() * sizeof(int), "taps");
    taps_ = device_.wrap_buffer(columns_.taps.data(), columns_.taps.size() * sizeof(MultumAverageTap), "taps");
    levels_ = device_.make_buffer(columns_.levels.size() * sizeof(MultumAverageLevel), "levels");
  }

  void read_band(int first_row, int rows) {
    const auto read = [&](const PlaneStore& store, AveragedPlanes::MapPlanes& planes) {
      for (int p = 0; p < static_cast<int>(kMapPlanes); ++p)
        device_.visit(planes[size_of(p)], [&](void* bytes) {
          auto* const values = static_cast<float*>(bytes);
          store.read_rows(p, first_row, rows, values);
          if (&planes == &normals_ && p == 2) planes_.see_z(values, size_of(rows) * size_of(width_));
        });
    };
    read(*inputs_.normals, normals_);
    if (has_colours()) read(*inputs_.albedo, colours_);
  }

  MultumAverageBand band_of(int first_row, int rows) const {
    MultumAverageBand band{};
    band.map_width = width_;
    band.map_height = height_;
    band.first_row = first_row;
    band.row_count = rows;
    band.row_length = row_length();
    band.plane_count = plane_count_;
    band.level_count = static_cast<int>(columns_.levels.size());
    band.column_count = column_count();
    return band;
  }

  void average(int first_row, int rows) {
    const MultumAverageBand band = band_of(first_row, rows);
    planes_.make_finest(normals_, has_colours() ? colours_ : normals_, nodes_, band);
    if (columns_.levels.empty()) return;
    for (int k = 1; k < blocks_.depth(); ++k)
      sum_blocks_.launch({size_of(plane_count_) * size_of(rows) * size_of(blocks_.block_count(k)), kAverageLocalSize},
                         nodes_, band, static_cast<int>(blocks_.block_begin(k - 1)),
                         static_cast<int>(blocks_.block_begin(k)), blocks_.block_count(k));
    int first_value = 0;
    for (MultumAverageLevel& level : columns_.levels) {
      const auto row_at = [&](int finest) { return static_cast<int>(std::int64_t{finest} * level.height / height_); };
      level.first_row = row_at(first_row);
      level.row_count = row_at(first_row + rows) - level.first_row;
      level.first_value = first_value;
      first_value += plane_count_ * level.row_count * level.width;
    }
    device_.write(levels_, columns_.levels.data(), columns_.levels.size() * sizeof(MultumAverageLevel));
    sum_levels_.launch({size_of(plane_count_) * size_of(column_count()), kAverageLocalSize}, nodes_, levels_,
                       tap_begin_, taps_, sums_, averages_, band);
  }

  void hand_over(int first_row, int rows) {
    if (inputs_.first_level == 0)
      device_.visit(nodes_, [&](void* bytes) {
        planes_.add_level(0, first_row,
                          {static_cast<const float*>(bytes), size_of(rows) * size_of(row_length()),
                           size_of(row_length()), width_, rows});
      });
    if (columns_.levels.empty()) return;
    device_.visit(averages_, [&](void* bytes) {
      for (std::size_t i = 0; i < columns_.levels.size(); ++i) {
        const MultumAverageLevel& level = columns_.levels[i];
        if (level.row_count == 0) continue;
        planes_.add_level(
            columns_.numbers[i], level.first_row,
            {static_cast<const float*>(bytes) + level.first_value, size_of(level.row_count) * size_of(level.width),
             size_of(level.width), level.width, level.row_count});
      }
    });
  }

  Device& device_;
  const AverageInputs& inputs_;
  AveragedPlanes& planes_;
  const int width_, height_, plane_count_;
  const RowBlocks blocks_;
  Columns columns_;
  const int band_rows_;
  AveragedPlanes::MapPlanes normals_, colours_;
  DeviceBuffer nodes_, averages_, sums_, tap_begin_, taps_, levels_;
  Kernel sum_blocks_, sum_levels_;
};

}  // namespace

void validate_averages(int first_level, int map_width, int map_height) {
  if (map_width > kAveragedSideMax || map_height > kAveragedSideMax)
    throw Error(ErrorCode::kInput, fmt::format("found a map of {} x {}, expected at most {} texels a side", map_width,
                                               map_height, kAveragedSideMax));
  const int level_max = mip_level_count(map_width, map_height) - 1;
  if (first_level < 0 || first_level > level_max)
    throw Error(ErrorCode::kUsage, fmt::format("--first-level is {}, expected 0 to {}, the levels of a map of {} x {}",
                                               first_level, level_max, map_width, map_height));
}

void average_map(Device& device, const AverageInputs& inputs, AveragedPlanes& planes, BakeReport& report,
                 Progress* progress) {
  const PlaneStore& normals = *inputs.normals;
  validate_averages(inputs.first_level, normals.width(), normals.height());
  MULTUM_CHECK(inputs.albedo == nullptr ||
               (inputs.albedo->width() == normals.width() && inputs.albedo->height() == normals.height()));
  AveragePass pass(device, inputs, planes);
  report.plan = pass.plan_text();
  report.device = device.info().name;
  pass.run(progress);
}

std::uint64_t waiting_bytes_beyond_usual(const BakedHeader& header, int tile_size, int values, int part_values) {
  constexpr std::uint64_t kUsual = std::uint64_t{32} << 20;
  std::uint64_t bytes = 0;
  for (int l = header.first_level; l < header.level_count(); ++l) {
    const std::uint64_t texels = static_cast<std::uint64_t>(mip_level_size(header.width, l)) *
                                 static_cast<std::uint64_t>(std::min(tile_size, mip_level_size(header.height, l)));
    bytes += texels * static_cast<std::uint64_t>(values) * sizeof(float);
    if (l == header.first_level) bytes += texels * static_cast<std::uint64_t>(part_values) * sizeof(std::uint16_t);
  }
  return bytes > kUsual ? bytes - kUsual : 0;
}

}  // namespace multum
