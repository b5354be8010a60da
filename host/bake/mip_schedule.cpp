// SPDX-License-Identifier: Apache-2.0
#include "host/bake/mip_schedule.h"

#include <algorithm>

#include "host/asset/movmf_mipmap.h"
#include "host/base/error.h"

namespace multum {
namespace {

// The largest number of finest texels that any texel of the level overlaps along an axis.
int covered_max(int map_size, int level_size) {
  int most = 0;
  for (std::int64_t x = 0; x < level_size; ++x) {
    const std::int64_t first = x * map_size / level_size;
    const std::int64_t last = ((x + 1) * map_size + level_size - 1) / level_size;  // one past
    most = std::max(most, static_cast<int>(last - first));
  }
  return most;
}

bool covers_whole_texels(int map_size) {
  for (int level = 1; mip_level_size(map_size, level - 1) > 1; ++level)
    if (map_size % mip_level_size(map_size, level) != 0) return false;
  return true;
}

// Appends a step of the given texels.
void add_step(LevelSchedule& level, const std::vector<int>& texels) {
  if (texels.empty()) return;
  level.steps.push_back({static_cast<int>(level.texel_list.size()), static_cast<int>(texels.size())});
  level.texel_list.insert(level.texel_list.end(), texels.begin(), texels.end());
  while (level.texel_list.size() % MULTUM_GROUP != 0) level.texel_list.push_back(-1);
}

// Four colours (x & 1, y & 1): (0,0), (1,1), (1,0), (0,1), as movmf_start.cl ranks them.
void add_colour_steps(LevelSchedule& level) {
  static constexpr int kColours[4][2] = {{0, 0}, {1, 1}, {1, 0}, {0, 1}};
  for (const auto& colour : kColours) {
    std::vector<int> texels;
    for (int y = colour[1]; y < level.fit.height; y += 2)
      for (int x = colour[0]; x < level.fit.width; x += 2) texels.push_back(y * level.fit.width + x);
    add_step(level, texels);
  }
}

// Scan-line order as a wavefront: a texel needs its left and its three upper neighbours, the last of them (x + 1, y -
// 1), so texel (x, y) belongs to step x + 2 y.
void add_wavefront_steps(LevelSchedule& level) {
  const int step_count = level.fit.width + 2 * (level.fit.height - 1);
  for (int step = 0; step < step_count; ++step) {
    std::vector<int> texels;
    const int y_first = std::max(0, (step - level.fit.width + 2) / 2);
    for (int y = y_first; y < level.fit.height && 2 * y <= step; ++y)
      texels.push_back(y * level.fit.width + step - 2 * y);
    add_step(level, texels);
  }
}

void choose_method(const MovmfSettings& settings, LevelSchedule& level) {
  MultumMovmfFit& fit = level.fit;
  const std::int64_t samples = static_cast<std::int64_t>(fit.sample_columns) * fit.sample_rows;
  if (samples <= kSamplesUnchunkedMax) {
    level.method = FitMethod::kTexels;
    fit.sample_capacity = static_cast<int>(samples);
  } else if (settings.coarse_normals == CoarseNormals::kCondensed) {
    level.method = FitMethod::kCondensed;
    fit.sample_capacity = MULTUM_CELL_COUNT;
    set_chunks(fit, kSamplesPerCondensedChunk, fit.sample_columns);
    return;
  } else {
    level.method = FitMethod::kChunks;
  }
  set_chunks(fit, kSamplesPerChunk, (fit.sample_columns + MULTUM_GROUP - 1) / MULTUM_GROUP * MULTUM_GROUP);
}

void choose_iterations(const MovmfSettings& settings, bool top, LevelSchedule& level) {
  MultumMovmfFit& fit = level.fit;
  level.iteration_count_again = settings.iteration_count_again;
  fit.iteration_count = top                                  ? settings.iteration_count_top
                        : level.method == FitMethod::kTexels ? settings.iteration_count
                                                             : settings.iteration_count_coarse;
  if (level.method != FitMethod::kTexels || settings.settled_change == 0.0f) return;
  if (1.0f / fit.total_weight_inverse < kFewNormals + 0.5f) {
    fit.iteration_count = std::min(fit.iteration_count, kIterationsFewNormals);
    level.iteration_count_again = std::min(level.iteration_count_again, kIterationsFewNormals);
  } else {
    fit.settled_change_squared = settings.settled_change * settings.settled_change;
  }
}

}  // namespace

void set_chunks(MultumMovmfFit& fit, int samples_per_chunk, int samples_per_row) {
  fit.chunk_rows = std::max(1, samples_per_chunk / samples_per_row);
  fit.chunk_count = (fit.sample_rows + fit.chunk_rows - 1) / fit.chunk_rows;
}

MipSchedule make_mip_schedule(int map_width, int map_height, const MovmfSettings& settings, bool weighted) {
  MULTUM_CHECK(map_width >= 1 && map_height >= 1 && map_width <= 32768 && map_height <= 32768);
  MipSchedule schedule;
  schedule.weighted = weighted || !covers_whole_texels(map_width) || !covers_whole_texels(map_height);
  const int level_count = mip_level_count(map_width, map_height);
  for (int l = level_count - 1; l >= std::max(1, settings.first_level); --l) {
    LevelSchedule level{};
    level.level = l;
    MultumMovmfFit& fit = level.fit;
    fit.map_width = map_width;
    fit.map_height = map_height;
    fit.width = mip_level_size(map_width, l);
    fit.height = mip_level_size(map_height, l);
    const bool top = l == level_count - 1;
    fit.parent_width = top ? 0 : mip_level_size(map_width, l + 1);
    fit.parent_height = top ? 0 : mip_level_size(map_height, l + 1);
    fit.sample_columns = covered_max(map_width, fit.width);
    fit.sample_rows = covered_max(map_height, fit.height);
    fit.order = settings.order == FitOrder::kScanline ? MULTUM_ORDER_SCANLINE : MULTUM_ORDER_COLOUR;
    // A scan line is done from its start to its end: what lies beyond its start is not done yet.
    const bool wraps = settings.order == FitOrder::kColour;
    fit.periodic_x = wraps && settings.periodic_x ? 1 : 0;
    fit.periodic_y = wraps && settings.periodic_y ? 1 : 0;
    fit.alignment = settings.alignment;
    fit.kappa_cap = settings.kappa_cap;
    fit.kappa_cap_slope = settings.kappa_cap_slope;
    fit.total_weight_inverse =
        static_cast<float>(static_cast<double>(fit.width) * fit.height / (static_cast<double>(map_width) * map_height));
    choose_method(settings, level);
    choose_iterations(settings, top, level);
    if (settings.order == FitOrder::kScanline) add_wavefront_steps(level);
    else add_colour_steps(level);
    schedule.levels.push_back(std::move(level));
  }
  return schedule;
}

}  // namespace multum
