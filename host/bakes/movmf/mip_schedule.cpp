// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/mip_schedule.h"

#include <algorithm>
#include <bit>

#include "host/bakes/pyramid/row_window.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

// The largest number of finest texels that any texel of the level overlaps along one axis.
int covered_max(int map_size, int level_size) {
  int most = 0;
  for (std::int64_t x = 0; x < level_size; ++x) {
    const std::int64_t first = x * map_size / level_size;
    const std::int64_t last = ((x + 1) * map_size + level_size - 1) / level_size;  // one past the last
    most = std::max(most, static_cast<int>(last - first));
  }
  return most;
}

bool covers_whole_texels(int map_size) {
  for (int level = 1; mip_level_size(map_size, level - 1) > 1; ++level)
    if (map_size % mip_level_size(map_size, level) != 0) return false;
  return true;
}

// Returns true for texels that cover exactly four normals and have a parent. Returns false for unaligned bakes, because
// the choice relies on alignment, and for --reference, which uses EM for all texels.
bool chooses(const MovmfSettings& settings, const MultumMovmfFit& fit) {
  return fit.map_width == 2 * fit.width && fit.map_height == 2 * fit.height && fit.parent_width > 0 &&
         settings.aligned_start && settings.alignment > 0.0f && settings.convergence_tolerance > 0.0f;
}

void choose_method(const MovmfSettings& settings, LevelSchedule& level) {
  MultumMovmfFit& fit = level.fit;
  const std::int64_t samples = static_cast<std::int64_t>(fit.sample_columns) * fit.sample_rows;
  if (samples <= kSamplesUnchunkedMax) {
    level.method = chooses(settings, fit) ? FitMethod::kChoice : FitMethod::kTexels;
    if (level.method == FitMethod::kChoice) fit.alignment *= kChoiceAlignment;
    fit.sample_capacity = static_cast<int>(samples);
  } else if (settings.coarse_normals == CoarseNormals::kBinned) {
    level.method = FitMethod::kBinned;
    fit.cell_side = samples <= kSamplesFewCellsMax ? kCellSideFew : kCellSide;
    fit.sample_capacity = fit.cell_side * fit.cell_side;
  } else {
    level.method = FitMethod::kChunks;
    const int columns = (fit.sample_columns + MULTUM_GROUP - 1) / MULTUM_GROUP * MULTUM_GROUP;
    fit.chunk_rows = std::max(1, kSamplesPerChunk / columns);
    fit.chunk_count = (fit.sample_rows + fit.chunk_rows - 1) / fit.chunk_rows;
    return;
  }
  // The colours of such a texel are summed in one chunk.
  fit.chunk_rows = fit.sample_rows;
  fit.chunk_count = 1;
}

void choose_iterations(const MovmfSettings& settings, bool top, LevelSchedule& level) {
  MultumMovmfFit& fit = level.fit;
  level.refit_iterations = settings.refit_iterations;
  if (level.method == FitMethod::kChoice) return;
  if (level.method != FitMethod::kTexels)
    level.refit_iterations = std::max(level.refit_iterations, settings.iteration_count_coarse / 3);
  fit.iteration_count = top                                  ? settings.iteration_count_top
                        : level.method == FitMethod::kTexels ? settings.iteration_count
                                                             : settings.iteration_count_coarse;
  if (level.method != FitMethod::kTexels || settings.convergence_tolerance == 0.0f) return;
  if (1.0f / fit.total_weight_inverse < kFewNormals + 0.5f) {
    fit.iteration_count = std::min(fit.iteration_count, kIterationsFewNormals);
    level.refit_iterations = std::min(level.refit_iterations, kIterationsFewNormals);
    fit.start_kappa_factor *= kStartFactorFewNormals;
    fit.alignment *= kAlignmentFactorFewNormals;
  } else {
    fit.convergence_tolerance_squared = settings.convergence_tolerance * settings.convergence_tolerance;
  }
}

// Four colours (x & 1, y & 1): (0,0), (1,1), (1,0), (0,1), in the order of movmf_start.cl.
constexpr int kColours[4][2] = {{0, 0}, {1, 1}, {1, 0}, {0, 1}};

int floor_divide(std::int64_t a, std::int64_t b) { return static_cast<int>(a >= 0 ? a / b : -((b - 1 - a) / b)); }

}  // namespace

bool MipSchedule::uses(FitMethod method) const {
  return std::any_of(levels.begin(), levels.end(), [&](const LevelSchedule& level) { return level.method == method; });
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
    // Scan-line order does not wrap, because texels across the border are fitted later.
    const bool wraps = settings.order == FitOrder::kColour;
    fit.periodic_x = wraps && settings.periodic_x ? 1 : 0;
    fit.periodic_y = wraps && settings.periodic_y ? 1 : 0;
    fit.start_kappa_factor = settings.start_kappa_factor;
    fit.start_amplitude_min = settings.start_amplitude_min;
    fit.alignment = settings.alignment;
    fit.kappa_cap = settings.kappa_cap;
    fit.kappa_cap_slope = settings.kappa_cap_slope;
    fit.total_weight_inverse =
        static_cast<float>(static_cast<double>(fit.width) * fit.height / (static_cast<double>(map_width) * map_height));
    choose_method(settings, level);
    choose_iterations(settings, top, level);
    fit.window_rows = fit.height;
    fit.parent_window_rows = fit.parent_height;
    fit.map_window_rows = map_height;
    level.order = settings.order;
    // Scan-line order runs as a wavefront. A texel needs its left and its three upper neighbours. The last of these to
    // be fitted is (x + 1, y - 1), so texel (x, y) belongs to step x + 2 y.
    level.step_count = level.order == FitOrder::kColour ? 4 : fit.width + 2 * (fit.height - 1);
    schedule.levels.push_back(level);
  }
  return schedule;
}

MipSchedule make_mip_schedule(const PlaneStore& normals, const MovmfSettings& settings, bool weighted) {
  MipSchedule schedule = make_mip_schedule(normals.width(), normals.height(), settings, weighted);
  if (normals.is_shortened()) make_shortened(schedule);
  return schedule;
}

void make_shortened(MipSchedule& schedule) {
  for (LevelSchedule& level : schedule.levels) {
    level.fit.shortened = 1;
    level.fit.extra_copies = kCopiesShortened - 1.0f;
    if (level.method != FitMethod::kBinned) continue;
    level.fit.cell_side = level.fit.cell_side == kCellSideFew ? kCellSideFewShortened : kCellSideShortened;
    level.fit.sample_capacity = MULTUM_LENGTH_CLASSES * level.fit.cell_side * level.fit.cell_side;
  }
}

void make_copies(MipSchedule& schedule, int count) {
  for (LevelSchedule& level : schedule.levels) {
    MultumMovmfFit& fit = level.fit;
    MULTUM_CHECK(fit.map_width == fit.map_height && std::has_single_bit(static_cast<unsigned>(fit.map_width)));
    fit.copy_height = fit.height;
    for (int* rows : {&fit.map_height, &fit.height, &fit.parent_height, &fit.window_rows, &fit.parent_window_rows,
                      &fit.map_window_rows})
      *rows *= count;
  }
}

std::vector<int> step_texels(const LevelSchedule& level, int step, int first_row, int last_row, int window_first_row) {
  const int width = level.fit.width, height = level.fit.height;
  std::vector<int> texels;
  for (int row = first_row; row < last_row; ++row) {
    const int place = (row - window_first_row) * width;
    if (level.order == FitOrder::kScanline) {
      const int x = step - 2 * row;
      if (x >= 0 && x < width) texels.push_back(place + x);
    } else if ((wrapped_row(row, height) & 1) == kColours[step][1]) {
      for (int x = kColours[step][0]; x < width; x += 2) texels.push_back(place + x);
    }
  }
  return texels;
}

int first_covered_row(const MultumMovmfFit& fit, int row) {
  return floor_divide(std::int64_t{row} * fit.map_height, fit.height);
}

int last_covered_row(const MultumMovmfFit& fit, int row) {
  return floor_divide((std::int64_t{row} + 1) * fit.map_height + fit.height - 1, fit.height);
}

}  // namespace multum
