// SPDX-License-Identifier: Apache-2.0
// A byte and the next lower byte form one number if the lower byte completes the higher one. If the second difference
// of the higher byte is b, it is 256 b in units of the lower byte. The second difference of both bytes together is much
// smaller, because the lower byte jumps in the opposite direction.
//
//   high       5   5   6   6          256 high + low   1430 1480 1536 1590
//   low      150 200   0  54          bends            by 6; 256 high bends by 256
//
// Colours never behave in this way. Their channels vary together, so the sum bends as much as the higher byte. The
// measured ratio is 0.02 to 0.4 for smooth heights, and at least 0.97 for the normal maps and colours of shared/data.
#include "host/formats/image/normals/packed_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "host/formats/image/files/number_type.h"

namespace multum {
namespace {

constexpr int kPackedRowsMax = 128;
constexpr double kBendShareMax = 0.5;
constexpr double kBendsMin = 32.0;  // smallest number of second differences for a decision

struct BytePair {
  double together = 0.0, high_alone = 0.0, count = 0.0;

  void add(double high, double low) {
    if (high == 0.0) return;
    together += std::abs(256.0 * high + low);
    high_alone += std::abs(256.0 * high);
    count += 1.0;
  }
  bool is_number() const { return count >= kBendsMin && together <= kBendShareMax * high_alone; }
};

struct PackedSums {
  BytePair red_green, green_blue;
  std::array<float, 3> low = {255.0f, 255.0f, 255.0f}, high = {0.0f, 0.0f, 0.0f};

  bool is_constant(std::size_t channel) const { return low[channel] == high[channel]; }
  bool is_within(std::size_t channel, float least, float most) const {
    return low[channel] >= least && high[channel] <= most;
  }
};

// Adds second differences along a row. In elevation tiles, black means no data, so it does not count for the range.
void add_row(const float* values, std::size_t width, std::size_t channel_count, PackedSums& sums) {
  const auto code = [&](std::size_t column, std::size_t channel) {
    return std::round(values[column * channel_count + channel] * 255.0f);
  };
  for (std::size_t column = 0; column < width; ++column) {
    std::array<float, 3> own = {};
    for (std::size_t c = 0; c < channel_count; ++c) own[c] = code(column, c);
    if (own == std::array<float, 3>{}) continue;
    for (std::size_t c = 0; c < channel_count; ++c) {
      sums.low[c] = std::min(sums.low[c], own[c]);
      sums.high[c] = std::max(sums.high[c], own[c]);
    }
    if (column == 0 || column + 1 == width) continue;
    std::array<double, 3> bend = {};
    for (std::size_t c = 0; c < channel_count; ++c)
      bend[c] = static_cast<double>(code(column - 1, c) - 2.0f * own[c] + code(column + 1, c));
    sums.red_green.add(bend[0], bend[1]);
    if (channel_count > 2) sums.green_blue.add(bend[1], bend[2]);
  }
}

// Ranges of red. In Terrarium and in Mapbox, heights reach from 11,000 m below the sea to 9,500 m above it. In Mapbox,
// red has units of 6553.6 m.
std::optional<HeightCoding> coding_of(const PackedSums& sums, bool has_blue) {
  const bool is_terrarium_red = sums.is_within(0, 85.0f, 165.0f), is_mapbox_red = sums.is_within(0, 0.0f, 2.0f);
  if (has_blue && !sums.is_constant(2)) {
    if (is_mapbox_red && sums.green_blue.is_number()) return HeightCoding::kMapbox;
    const bool is_number = sums.red_green.is_number() || (sums.is_constant(0) && sums.green_blue.is_number());
    if (is_terrarium_red && is_number) return HeightCoding::kTerrarium;
    // Blue also continues the number, so it is not an unused channel.
    if (sums.red_green.is_number() && sums.green_blue.is_number()) return HeightCoding::kPacked24;
  }
  if (!sums.red_green.is_number()) return std::nullopt;
  // The range of red for heights in whole metres. It is small and exactly at sea level. The heights of a 16-bit picture
  // would hardly use only such a part of its range.
  constexpr float kTerrariumLow = 127.0f, kTerrariumHigh = 163.0f;
  const bool are_metres =
      has_blue && sums.is_constant(2) && sums.low[2] == 0.0f && sums.is_within(0, kTerrariumLow, kTerrariumHigh);
  return are_metres ? HeightCoding::kTerrarium : HeightCoding::kPacked16;
}

}  // namespace

std::optional<HeightCoding> find_packed_heights(const RawImage& image) {
  const RawImageInfo& info = image.info();
  if (info.base_type != number_type::kUint8 || info.channel_count < 2) return std::nullopt;
  PackedSums sums;
  RawRows rows;
  const int count = std::min(kPackedRowsMax, info.height);
  for (int i = 0; i < count; ++i) {
    image.read_rows(static_cast<int>(static_cast<std::int64_t>(i) * info.height / count), 1, rows);
    add_row(rows.values.data(), static_cast<std::size_t>(info.width), static_cast<std::size_t>(info.channel_count),
            sums);
  }
  return coding_of(sums, info.channel_count > 2);
}

}  // namespace multum
