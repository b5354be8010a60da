// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/texel_averages.h"

#include <algorithm>

#include "host/foundation/base/error.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

MULTUM_VECTOR_CLONES
void add_pairs(const double* __restrict values, int pair_count, double* __restrict sums) {
  for (int i = 0; i < pair_count; ++i) sums[i] = values[2 * i] + values[2 * i + 1];
}

}  // namespace

TexelAverages::TexelAverages(const TexelSelection& texels, int level_count)
    : texels_(texels), level_count_(level_count), blocks_(texels.sizes().front().width) {
  MULTUM_CHECK(level_count >= 0 && static_cast<std::size_t>(level_count) <= texels.sizes().size());
  for (int l = 0; l < level_count; ++l) {
    const bool is_empty = texels.level_begin(l) == texels.level_begin(l + 1);
    levels_.push_back(is_empty ? Level{} : make_level(texels.sizes()[static_cast<std::size_t>(l)].width));
  }
}

TexelAverages::Level TexelAverages::make_level(int width) const {
  Level level;
  for (int x = 0; x < width; ++x) {
    level.tap_begin.push_back(static_cast<std::uint32_t>(level.taps.size()));
    blocks_.append_taps(width, x, level.taps);
  }
  level.tap_begin.push_back(static_cast<std::uint32_t>(level.taps.size()));
  return level;
}

void TexelAverages::sum_blocks(double* row) const {
  for (int k = 1; k < blocks_.depth(); ++k)
    add_pairs(row + blocks_.block_begin(k - 1), blocks_.block_count(k), row + blocks_.block_begin(k));
}

void TexelAverages::add_row(int y, double* row, double* sums, std::size_t stride) const {
  sum_blocks(row);
  const std::int64_t map_height = texels_.sizes().front().height;
  for (int l = 0; l < level_count_; ++l) {
    const Level& level = levels_[static_cast<std::size_t>(l)];
    if (level.taps.empty()) continue;
    const std::int64_t height = texels_.sizes()[static_cast<std::size_t>(l)].height;
    // Positions are in units of 1/height of a finest row. This row is [y height, (y + 1) height), and row r of a level
    // is [r map_height, (r + 1) map_height). A finest row overlaps one or two rows of the level.
    const std::int64_t begin = y * height, end = begin + height;
    for (std::int64_t r = begin / map_height; r * map_height < end; ++r) {
      const std::int64_t overlap = std::min(end, (r + 1) * map_height) - std::max(begin, r * map_height);
      const double row_weight = static_cast<double>(overlap) / static_cast<double>(height);
      const std::size_t slot_end = texels_.row_end(l, static_cast<int>(r));
      for (std::size_t slot = texels_.row_begin(l, static_cast<int>(r)); slot < slot_end; ++slot) {
        const auto column = static_cast<std::size_t>(texels_.column(slot));
        double sum = 0.0;
        for (std::uint32_t t = level.tap_begin[column]; t < level.tap_begin[column + 1]; ++t)
          sum += level.taps[t].weight * row[level.taps[t].node];
        sums[slot * stride] += row_weight * sum;
      }
    }
  }
}

double TexelAverages::share(int level) const {
  const PlaneSize map = texels_.sizes().front(), size = texels_.sizes()[static_cast<std::size_t>(level)];
  return static_cast<double>(size.width) * size.height / (static_cast<double>(map.width) * map.height);
}

}  // namespace multum
