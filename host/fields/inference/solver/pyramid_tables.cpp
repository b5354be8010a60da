// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/solver/pyramid_tables.h"

#include <algorithm>
#include <cmath>

namespace multum {
namespace {

// Returns the position of a fine texel's centre among the centres of the coarse texels.
MultumTap tap_of(int fine, int fine_count, int coarse_count, bool is_periodic) {
  double at = (fine + 0.5) * coarse_count / fine_count - 0.5;
  if (!is_periodic) at = std::clamp(at, 0.0, coarse_count - 1.0);
  const int first = static_cast<int>(std::floor(at));
  const auto place = [&](int i) {
    return is_periodic ? (i + coarse_count) % coarse_count : std::min(i, coarse_count - 1);
  };
  return {place(first), place(first + 1), static_cast<float>(at - first), 0};
}

// Handles one direction of a level and the next coarser level. Appends the taps of the fine texels and the gathers of
// the coarse texels, and returns the coarse texels' sums of squared weights.
std::vector<float> add_direction(int fine_count, int coarse_count, bool is_periodic, PyramidTables& tables) {
  std::vector<std::vector<MultumGatherEntry>> gathered(static_cast<std::size_t>(coarse_count));
  for (int i = 0; i < fine_count; ++i) {
    const MultumTap tap = tap_of(i, fine_count, coarse_count, is_periodic);
    tables.taps.push_back(tap);
    const auto add = [&](int coarse, float weight) {
      if (weight == 0.0f) return;
      auto& list = gathered[static_cast<std::size_t>(coarse)];
      if (!list.empty() && list.back().fine == i) list.back().weight += weight;
      else list.push_back({i, weight});
    };
    add(tap.first, 1.0f - tap.fraction);
    add(tap.second, tap.fraction);
  }
  std::vector<float> squares;
  for (const auto& list : gathered) {
    tables.gathers.push_back({static_cast<int>(tables.entries.size()), static_cast<int>(list.size())});
    tables.entries.insert(tables.entries.end(), list.begin(), list.end());
    float square = 0.0f;
    for (const MultumGatherEntry& entry : list) square += entry.weight * entry.weight;
    squares.push_back(square);
  }
  return squares;
}

}  // namespace

PyramidTables make_pyramid_tables(const MipLayout& layout, bool is_periodic_s, bool is_periodic_t, int strip_length) {
  PyramidTables tables;
  tables.diagonal.assign(static_cast<std::size_t>(layout.texel_count), 0.0f);
  for (const MipLevelPlace& level : layout.levels)
    tables.levels.push_back({level.offset, level.width, level.height, 0, 0, 0, 0, 0});
  for (std::size_t l = 0; l + 1 < layout.levels.size(); ++l) {
    const MipLevelPlace &fine = layout.levels[l], &coarse = layout.levels[l + 1];
    tables.levels[l].taps_x = static_cast<int>(tables.taps.size());
    tables.levels[l + 1].gathers_x = static_cast<int>(tables.gathers.size());
    const std::vector<float> across = add_direction(fine.width, coarse.width, is_periodic_s, tables);
    tables.levels[l].taps_y = static_cast<int>(tables.taps.size());
    tables.levels[l + 1].gathers_y = static_cast<int>(tables.gathers.size());
    const std::vector<float> down = add_direction(fine.height, coarse.height, is_periodic_t, tables);
    // The diagonal element of a texel is 1 if the texel is interpolated, plus the squares of its weights in finer
    // texels.
    for (int t = fine.offset; t < coarse.offset; ++t) tables.diagonal[static_cast<std::size_t>(t)] += 1.0f;
    for (int y = 0; y < coarse.height; ++y)
      for (int x = 0; x < coarse.width; ++x)
        tables.diagonal[static_cast<std::size_t>(coarse.offset + y * coarse.width + x)] +=
            across[static_cast<std::size_t>(x)] * down[static_cast<std::size_t>(y)];
  }
  for (std::size_t l = 0; l < layout.levels.size(); ++l)
    for (int y = 0; y < layout.levels[l].height; ++y)
      for (int x = 0; x < layout.levels[l].width; x += strip_length)
        tables.strips.push_back({static_cast<int>(l), y, x, std::min(x + strip_length, layout.levels[l].width)});
  return tables;
}

}  // namespace multum
