// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/box_pyramid.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

// More memory does not make a bake faster. Averaging a map of 4096 x 4096 texels takes 3.6 s in bands of 16 MiB, 3.9 s
// in bands of 64 MiB and 4.5 s in bands of 2 MiB. These times are medians of three runs on 2 cores of an AMD EPYC with
// PoCL 3.1, while other programs were running.
constexpr std::uint64_t kUsefulBandBytes = std::uint64_t{16} << 20;
constexpr int kBoxMapSideMax = 32768;  // with this limit, products of two sides fit into an int

}  // namespace

void validate_box_map(int first_level, int map_width, int map_height) {
  if (map_width > kBoxMapSideMax || map_height > kBoxMapSideMax)
    throw Error(ErrorCode::kInput, fmt::format("found a map of {} x {}, expected at most {} texels per side", map_width,
                                               map_height, kBoxMapSideMax));
  const int level_max = mip_level_count(map_width, map_height) - 1;
  if (first_level < 0 || first_level > level_max)
    throw Error(ErrorCode::kUsage,
                fmt::format("--first-level is {}, expected a level from 0 to {} for a map of {} x {}", first_level,
                            level_max, map_width, map_height));
}

BoxPyramid::BoxPyramid(Device& device, const BoxMap& map, const Memory& memory)
    : device_(device), map_(map), memory_(memory), blocks_(map.width) {
  make_columns();
  band_rows_ = choose_band_rows();
  make_buffers();
  sum_blocks_ = device.kernel("mip_box", "mip_blocks", {1, 1, false});
  sum_levels_ = device.kernel("mip_box", "mip_levels", {1, 1, false});
}

void BoxPyramid::make_columns() {
  std::vector<RowBlocks::Tap> taps;
  for (int l = std::max(1, map_.first_level); l < mip_level_count(map_.width, map_.height); ++l) {
    MultumBoxLevel level{};
    level.width = mip_level_size(map_.width, l);
    level.height = mip_level_size(map_.height, l);
    level.first_column = static_cast<int>(tap_begin_values_.size());
    level.share = static_cast<float>(static_cast<double>(level.width) * level.height /
                                     (static_cast<double>(map_.width) * map_.height));
    for (int x = 0; x < level.width; ++x) {
      tap_begin_values_.push_back(static_cast<int>(tap_values_.size()));
      taps.clear();
      blocks_.append_taps(level.width, x, taps);
      for (const RowBlocks::Tap& tap : taps)
        tap_values_.push_back({static_cast<int>(tap.node), static_cast<float>(tap.weight)});
    }
    level_values_.push_back(level);
    level_numbers_.push_back(l);
  }
  tap_begin_values_.push_back(static_cast<int>(tap_values_.size()));
}

// Returns the distance between rows of nodes. The distance is rounded up, but not to a power of two, because rows at
// such a distance would compete for the same cache sets.
int BoxPyramid::row_length() const { return static_cast<int>((blocks_.node_count() + 15) / 16 * 16 + 16); }

// Returns the memory for one more row per band.
std::uint64_t BoxPyramid::row_bytes() const {
  return (memory_.caller_row_values + size_of(map_.plane_count) * size_of(row_length())) * sizeof(float);
}

std::uint64_t BoxPyramid::fixed_bytes() const {
  const std::size_t columns = size_of(column_count()), planes = size_of(map_.plane_count);
  // For any band height, there are two rows of every level, one for the averages and one for the handover.
  return columns * planes * 4 * sizeof(float) + columns * sizeof(int) + tap_values_.size() * sizeof(MultumBoxTap);
}

std::uint64_t BoxPyramid::buffer_bytes() const { return fixed_bytes() + size_of(band_rows_) * row_bytes(); }

int BoxPyramid::choose_band_rows() const {
  if (fixed_bytes() + row_bytes() > memory_.bytes)
    throw Error(
        ErrorCode::kUsage,
        fmt::format("--memory leaves {} KiB for buffers, expected at least {} KiB for one row of a map of {} x {}",
                    memory_.bytes >> 10, ((fixed_bytes() + row_bytes()) >> 10) + 1, map_.width, map_.height));
  const std::uint64_t bytes = std::min(kUsefulBandBytes, memory_.bytes - fixed_bytes());
  return static_cast<int>(std::clamp<std::uint64_t>(bytes / row_bytes(), 1, static_cast<std::uint64_t>(map_.height)));
}

void BoxPyramid::make_buffers() {
  const std::size_t planes = size_of(map_.plane_count);
  nodes_ = device_.make_buffer(planes * size_of(band_rows_) * size_of(row_length()) * sizeof(float), "nodes of rows");
  std::size_t values = 1;
  for (const MultumBoxLevel& level : level_values_) {
    // The largest number of rows of the level that a band finishes.
    const int rows = static_cast<int>(std::int64_t{band_rows_} * level.height / map_.height) + 1;
    values += planes * size_of(rows) * size_of(level.width);
  }
  averages_ = device_.make_buffer(values * sizeof(float), "averages");
  sums_ = device_.make_buffer(std::max<std::size_t>(1, planes * size_of(column_count())) * 2 * sizeof(float),
                              "sums of columns");
  device_.fill_zero(sums_);
  if (level_values_.empty()) return;
  tap_begin_ = device_.wrap_buffer(tap_begin_values_.data(), tap_begin_values_.size() * sizeof(int), "taps");
  taps_ = device_.wrap_buffer(tap_values_.data(), tap_values_.size() * sizeof(MultumBoxTap), "taps");
  levels_ = device_.make_buffer(level_values_.size() * sizeof(MultumBoxLevel), "levels");
}

MultumBoxBand BoxPyramid::band(int first_row, int row_count) const {
  MultumBoxBand band{};
  band.map_width = map_.width;
  band.map_height = map_.height;
  band.first_row = first_row;
  band.row_count = row_count;
  band.row_length = row_length();
  band.plane_count = map_.plane_count;
  band.level_count = static_cast<int>(level_values_.size());
  band.column_count = column_count();
  return band;
}

void BoxPyramid::average(const MultumBoxBand& band) {
  if (level_values_.empty()) return;
  const std::size_t rows = size_of(band.plane_count) * size_of(band.row_count);
  for (int k = 1; k < blocks_.depth(); ++k)
    sum_blocks_.launch({rows * size_of(blocks_.block_count(k)), kBoxLocalSize}, nodes_, band,
                       static_cast<int>(blocks_.block_begin(k - 1)), static_cast<int>(blocks_.block_begin(k)),
                       blocks_.block_count(k));
  int first_value = 0;
  for (MultumBoxLevel& level : level_values_) {
    const auto row_at = [&](int finest) { return static_cast<int>(std::int64_t{finest} * level.height / map_.height); };
    level.first_row = row_at(band.first_row);
    level.row_count = row_at(band.first_row + band.row_count) - level.first_row;
    level.first_value = first_value;
    first_value += band.plane_count * level.row_count * level.width;
  }
  device_.write(levels_, level_values_.data(), level_values_.size() * sizeof(MultumBoxLevel));
  sum_levels_.launch({size_of(band.plane_count) * size_of(column_count()), kBoxLocalSize}, nodes_, levels_, tap_begin_,
                     taps_, sums_, averages_, band);
}

void BoxPyramid::hand_over(const MultumBoxBand& band, const std::function<void(const BoxRows&)>& consume) {
  const std::size_t plane_size = size_of(band.row_count) * size_of(band.row_length);
  if (map_.first_level == 0)
    device_.read_ranges({{&nodes_, 0, size_of(band.plane_count) * plane_size * sizeof(float)}},
                        [&](const Device::Bytes& at) {
                          consume({0, band.first_row, map_.width, band.row_count, reinterpret_cast<const float*>(at[0]),
                                   plane_size, size_of(band.row_length)});
                        });
  if (level_values_.empty()) return;
  std::size_t values = 0;
  for (const MultumBoxLevel& level : level_values_)
    values += size_of(band.plane_count) * size_of(level.row_count) * size_of(level.width);
  device_.read_ranges({{&averages_, 0, values * sizeof(float)}}, [&](const Device::Bytes& at) {
    for (std::size_t i = 0; i < level_values_.size(); ++i) {
      const MultumBoxLevel& level = level_values_[i];
      if (level.row_count == 0) continue;
      consume({level_numbers_[i], level.first_row, level.width, level.row_count,
               reinterpret_cast<const float*>(at[0]) + level.first_value,
               size_of(level.row_count) * size_of(level.width), size_of(level.width)});
    }
  });
}

}  // namespace multum
