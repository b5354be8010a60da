// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/movmf_level_fit.h"

#include <algorithm>
#include <cmath>

#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/opencl/launch_shape.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

// The row counts of the windows of a level, for a plan.
struct WindowRows {
  int level, parent, map;
};

// Number of steps of EM.
int em_steps(const LevelSchedule& level, const MovmfSettings& settings) {
  const bool has_parent = level.fit.parent_width > 0 && settings.aligned_start;
  return level.step_count * (has_parent ? settings.pass_count : 1);
}

// Adds the refinement, which is a last step for all texels and reads the EM lobes of neighbours.
int total_steps(const LevelSchedule& level, const MovmfSettings& settings) {
  return em_steps(level, settings) + (is_refined(level, settings) ? 1 : 0);
}

// True if windows hold the whole level. Scan-line order needs the whole level. So do chunks, because they are summed
// for all texels at once, band by band of the map. A window that would hold nearly all rows holds the whole level
// instead.
bool is_whole(const LevelSchedule& level, const MovmfSettings& settings, const BandPlan& plan) {
  return plan.band_rows + total_steps(level, settings) >= level.fit.height || level.order == FitOrder::kScanline ||
         level.method == FitMethod::kChunks;
}

int parent_row_of(const MultumMovmfFit& fit, int row) {
  const int real = wrapped_row(row, fit.height);
  return std::min(real >> 1, fit.parent_height - 1) + (row - real) / fit.height * fit.parent_height;
}

// Returns one past the last map row that texels of rows up to `row` read.
int map_rows_end(const MultumMovmfFit& fit, int row) { return first_covered_row(fit, row) + fit.sample_rows; }

WindowRows window_rows(const LevelSchedule& level, const MovmfSettings& settings, const BandPlan& plan) {
  const MultumMovmfFit& fit = level.fit;
  WindowRows rows{fit.height, fit.parent_height, fit.map_height};
  if (!is_whole(level, settings, plan)) {
    rows.level = plan.band_rows + total_steps(level, settings);
    rows.parent = rows.level / 2 + 5;  // with one more row above and below, because movmf_choose.cl reads neighbours
    rows.map = map_rows_end(fit, rows.level) + 1;
  }
  if (level.method == FitMethod::kChunks)
    rows.map = std::min(fit.map_height, std::max(plan.map_band_rows, fit.chunk_rows + 1));
  return rows;
}

// Returns the number of rows per handover, usually the rows of a band. On a device with its own memory, bands are
// large, so a handover has only as many rows as the host should hold.
int handed_rows(const Device& device, const LevelSchedule& level, const MovmfSettings& settings, const MapInputs& map,
                int band_rows) {
  constexpr std::size_t kHandedBytes = std::size_t{64} << 20;
  if (device.shape().window_bytes_max == 0) return band_rows;
  const std::size_t texel = static_cast<std::size_t>(settings.lobe_count) *
                            (sizeof(MultumVmfLobe) + map.features.rgb_planes.size() * 3 * sizeof(float));
  const std::size_t rows = kHandedBytes / (texel * static_cast<std::size_t>(level.fit.width));
  return static_cast<int>(std::clamp<std::size_t>(rows, 1, static_cast<std::size_t>(band_rows)));
}

}  // namespace

bool is_refined(const LevelSchedule& level, const MovmfSettings& settings) {
  return settings.refine && 1.0f / level.fit.total_weight_inverse > kRefinedNormalsMin;
}

LevelFit::LevelFit(Device& device, MovmfEmStep& em_step, const LevelSchedule& level, const MovmfSettings& settings,
                   const MapInputs& map, CoarseTexels& coarse, RowOrigin& origin, const LevelRows& fitted,
                   const BandPlan& plan, Progress* progress)
    : em_step_(em_step),
      level_(level),
      fit_(level.fit),
      map_(map),
      coarse_(coarse),
      has_parent_(level.fit.parent_width > 0 && settings.aligned_start),
      range_(origin.range(level.level)),
      before_(origin.before()),
      parent_(has_parent_ ? origin.parent() : nullptr),
      lobe_count_(settings.lobe_count),
      gaussians_(lobe_family(settings.representation).is_planar),
      whole_(is_whole(level, settings, plan)),
      band_rows_(whole_ ? level.fit.height : plan.band_rows),
      em_steps_(em_steps(level, settings)),
      steps_(total_steps(level, settings)),
      handed_rows_(handed_rows(device, level, settings, map, band_rows_)),
      wanted_(range_ ? RowRange{range_->y0, range_->y1} : fitted),
      progress_(progress) {
  make_windows(device, settings, coarse, plan);
}

void LevelFit::make_windows(Device& device, const MovmfSettings& settings, CoarseTexels& coarse, const BandPlan& plan) {
  const WindowRows rows = window_rows(level_, settings, plan);
  const auto row_bytes = [](int columns, std::size_t texel) { return static_cast<std::size_t>(columns) * texel; };
  const std::size_t lobe_row = row_bytes(fit_.width, sizeof(MultumVmfLobe));
  windows_.lobes = RowWindow(device, lobe_count_, lobe_row, rows.level, "the lobes of a level");
  windows_.alignment_vectors = RowWindow(device, lobe_count_, lobe_row, rows.level, "the directions of a level");
  if (refines()) windows_.refined = RowWindow(device, lobe_count_, lobe_row, rows.level, "refined lobes of a level");
  if (has_features())
    windows_.features = RowWindow(device, lobe_count_ * static_cast<int>(map_.features.rgb_planes.size()),
                                  row_bytes(fit_.width, 3 * sizeof(float)), rows.level, "the features of a level");
  if (has_parent_)
    windows_.parent = RowWindow(device, lobe_count_, row_bytes(fit_.parent_width, sizeof(MultumVmfLobe)), rows.parent,
                                "the lobes of the next coarser level");
  else fit_.parent_width = fit_.parent_height = 0;
  if (level_.method == FitMethod::kBinned) {
    const std::size_t samples = binned_bytes(fit_);
    windows_.binned = RowWindow(device, 1, row_bytes(fit_.width, samples), rows.level, "binned normals");
    windows_.binned_counts = RowWindow(device, 1, row_bytes(fit_.width, sizeof(int)), rows.level, "numbers of them");
    for (std::size_t t = 0; t < map_.features.rgb_planes.size(); ++t)
      windows_.binned_planes.emplace_back(device, 1, row_bytes(fit_.width, samples), rows.level, "binned features");
  } else {
    if (!coarse.on_device || !whole_)
      windows_of_map_.emplace(device, *map_.normals, map_.features.rgb_planes, rows.map);
    windows_.map = windows_of_map_ ? &*windows_of_map_ : &*coarse.on_device;
  }
}

void LevelFit::run(const std::function<void(const FittedRows&)>& finished) {
  const RowRange first = rows_of_step(0), last = rows_of_step(steps_ - 1);
  for (int front = whole_ ? 0 : first.begin; front - steps_ + 1 < last.end; front += band_rows_) {
    const int window_begin = whole_ ? 0 : std::max(front - steps_, lower_bound());
    const int window_end = whole_ ? fit_.height : std::min(front + band_rows_, upper_bound());
    if (window_begin < window_end) move_windows({window_begin, window_end});
    for (int step = 0; step < steps_; ++step) {
      const int lag = whole_ ? 0 : step;
      const RowRange rows = common_rows({front - lag, front - lag + band_rows_}, rows_of_step(step));
      if (rows.begin >= rows.end) continue;
      if (step == em_steps_) {
        refine(rows);
        continue;
      }
      windows_.wants_features = has_features() && step >= em_steps_ - level_.step_count;
      em_step_.run(level_.method, fit_of_pass(step / level_.step_count), texels_of_step(step % level_.step_count, rows),
                   windows_, progress_);
    }
    em_step_.finish(progress_);
    const int lag = whole_ ? 0 : steps_ - 1;
    const RowRange done = common_rows({front - lag, front - lag + band_rows_}, wanted_);
    for (int row = done.begin; row < done.end; row += handed_rows_) {
      const int count = std::min(handed_rows_, done.end - row);
      finished({row, count, refines() ? &windows_.refined : &windows_.lobes,
                has_features() ? &windows_.features : nullptr, reads_map_rows() ? &windows_.map->normals : nullptr,
                fit_, &windows_.lobes});
    }
    if (whole_) break;
  }
}

// Returns the rows that step `step` must fit so that the last step's rows are correct. Each step must fit one more row
// on each side than the step after it.
LevelFit::RowRange LevelFit::rows_of_step(int step) const {
  if (range_) return wanted_;  // texels outside the range keep their lobes
  if (whole_) return {0, fit_.height};
  const int more = steps_ - 1 - step;
  return {std::max(wanted_.begin - more, lower_bound()), std::min(wanted_.end + more, upper_bound())};
}

void LevelFit::move_windows(RowRange rows) {
  const int count = rows.end - rows.begin;
  windows_.lobes.move_to(rows.begin, count, before_);
  // Neighbours that are not fitted again provide the lobes that they already have.
  if (refines()) windows_.refined.move_to(rows.begin, count, range_ ? before_ : nullptr);
  windows_.alignment_vectors.move_to(rows.begin, count, range_ ? fill_alignment_vectors(before_) : nullptr);
  if (has_features()) windows_.features.move_to(rows.begin, count, nullptr);
  fit_.first_row = wrapped_row(rows.begin, fit_.height);
  fit_.window_rows = windows_.lobes.capacity_rows();
  if (has_parent_) {
    int begin = 0, end = fit_.parent_height;
    if (!whole_) {
      begin = parent_row_of(fit_, rows.begin) - 1;
      end = parent_row_of(fit_, rows.end - 1) + 2;
      if (!repeats()) {
        begin = std::max(begin, 0);
        end = std::min(end, fit_.parent_height);
      }
    }
    windows_.parent.move_to(begin, end - begin, parent_);
    fit_.parent_first_row = wrapped_row(begin, fit_.parent_height);
    fit_.parent_window_rows = windows_.parent.capacity_rows();
  }
  if (level_.method == FitMethod::kBinned) {
    const BinnedLevel& from = coarse_.binned.at(level_.level);
    windows_.binned.move_to(rows.begin, count, fill_binned(from, from.samples, binned_bytes(fit_)));
    windows_.binned_counts.move_to(rows.begin, count, fill_planes(from.counts));
    for (std::size_t t = 0; t < windows_.binned_planes.size(); ++t)
      windows_.binned_planes[t].move_to(rows.begin, count, fill_binned(from, from.rgb_planes[t], binned_bytes(fit_)));
  } else if (reads_map_rows()) {
    const int begin = whole_ ? 0 : first_covered_row(fit_, rows.begin);
    const int end = whole_ ? fit_.map_height : last_map_row(rows.end - 1);
    windows_.map->move_to(begin, end - begin);
    fit_.map_first_row = wrapped_row(begin, fit_.map_height);
    fit_.map_window_rows = end - begin;
  }
}

int LevelFit::last_map_row(int row) const {
  const int end = map_rows_end(fit_, row);
  return repeats() ? end : std::min(end, fit_.map_height);
}

// Fills the alignment vectors of lobes that existed before the fit, in the same way as movmf_em_texels.cl.
RowWindow::Fill LevelFit::fill_alignment_vectors(const RowWindow::Fill& fill_lobes) {
  return [this, fill_lobes](int row, int count, const std::vector<unsigned char*>& planes) {
    fill_lobes(row, count, planes);
    for (unsigned char* plane : planes) {
      auto* lobes = reinterpret_cast<MultumVmfLobe*>(plane);
      for (int i = 0; i < count * fit_.width; ++i) {
        MultumVmfLobe& lobe = lobes[i];
        if (gaussians_) {
          lobe = {lobe.mean_x * lobe.amplitude, lobe.mean_y * lobe.amplitude, lobe.amplitude, 0.0f};
          continue;
        }
        const float squared = lobe.mean_x * lobe.mean_x + lobe.mean_y * lobe.mean_y + lobe.mean_z * lobe.mean_z;
        const float scale = squared > 1e-24f ? lobe.amplitude / std::sqrt(squared) : 0.0f;
        lobe = {lobe.mean_x * scale, lobe.mean_y * scale, lobe.mean_z * scale, lobe.amplitude * scale};
      }
    }
  };
}

MultumMovmfFit LevelFit::fit_of_pass(int pass) const {
  MultumMovmfFit fit = fit_;
  if (pass > 0) {
    fit.order = MULTUM_ORDER_AGAIN;
    fit.iteration_count = level_.refit_iterations;
  }
  return fit;
}

std::vector<int> LevelFit::texels_of_step(int step, RowRange rows) const {
  std::vector<int> texels = step_texels(level_, step, rows.begin, rows.end, windows_.lobes.first_row());
  if (range_)
    std::erase_if(texels, [&](int texel) {
      const int x = texel % fit_.width;
      return x < range_->x0 || x >= range_->x1;
    });
  return texels;
}

// Uses the steps of the fit, so that no launch has more texels than an EM launch.
void LevelFit::refine(RowRange rows) {
  for (int step = 0; step < level_.step_count; ++step)
    em_step_.refine(level_.method, fit_, texels_of_step(step, rows), windows_, progress_);
}

std::vector<LevelRows> handed_ranges(const Device& device, const LevelSchedule& level, const MovmfSettings& settings,
                                     const MapInputs& map, const BandPlan& plan) {
  const int height = level.fit.height, more = total_steps(level, settings) - 1;
  const bool whole = is_whole(level, settings, plan), repeats = level.fit.periodic_y != 0 && level.fit.parent_width > 0;
  const int band = whole ? height : plan.band_rows, handed = handed_rows(device, level, settings, map, band);
  std::vector<LevelRows> ranges;
  for (int begin = whole ? 0 : repeats ? -2 * more : -more; begin < height; begin += band)
    for (int row = std::max(begin, 0); row < std::min(begin + band, height); row += handed)
      ranges.push_back({row, std::min({row + handed, begin + band, height})});
  return ranges;
}

int fit_steps(const LevelSchedule& level, const MovmfSettings& settings) { return total_steps(level, settings); }

std::uint64_t fit_level_bytes(const LevelSchedule& level, const MovmfSettings& settings, int rgb_plane_count,
                              const BandPlan& plan) {
  const MultumMovmfFit& fit = level.fit;
  const WindowRows rows = window_rows(level, settings, plan);
  const auto product = [](int a, int b) { return static_cast<std::uint64_t>(a) * static_cast<std::uint64_t>(b); };
  const auto lobes = static_cast<std::uint64_t>(settings.lobe_count);
  const auto rgb_planes = static_cast<std::uint64_t>(rgb_plane_count);
  const std::uint64_t lobe_bytes = lobes * sizeof(MultumVmfLobe),
                      feature_bytes = rgb_planes * lobes * 3 * sizeof(float);
  std::uint64_t texel_bytes = (is_refined(level, settings) ? 3 : 2) * lobe_bytes + feature_bytes;
  if (level.method == FitMethod::kBinned) texel_bytes += binned_bytes(fit) * (1 + rgb_planes) + sizeof(int);
  std::uint64_t bytes = product(fit.width, rows.level) * texel_bytes;
  bytes += product(fit.parent_width, rows.parent) * lobe_bytes;
  if (level.method != FitMethod::kBinned)
    bytes += product(fit.map_width, rows.map) * sizeof(float) * 3 * (1 + rgb_planes);
  // The largest step has a quarter of a band's texels. In scan-line order, the largest step has one texel per two rows.
  const int step_rows = is_whole(level, settings, plan) ? fit.height : plan.band_rows;
  const std::uint64_t step_texels = level.order == FitOrder::kScanline
                                        ? static_cast<std::uint64_t>(fit.height / 2 + 1)
                                        : product((fit.width + 1) / 2, (step_rows + 1) / 2);
  bytes += em_step_bytes(level, settings, rgb_plane_count > 0, step_texels);
  // Adds the bytes of the rows that are handed over, in the fitted form and in the stored form.
  return bytes + product(fit.width, step_rows) * 2 * (lobe_bytes + feature_bytes);
}

}  // namespace multum
