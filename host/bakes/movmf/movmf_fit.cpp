// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/movmf_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "host/bakes/movmf/lobe_rows.h"
#include "host/bakes/movmf/movmf_start.h"
#include "host/bakes/pyramid/finest_rows.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

ProgramChoice level_zero_program(const Device& device, const MipSchedule& schedule, const MovmfSettings& settings) {
  return {"movmf_level_zero",
          {settings.lobe_count, device.shape().vector_width, schedule.weighted,
           lobe_family(settings.representation).is_planar}};
}

PlaneStore rows_of(const PlaneStore& store, int first_row, int row_count) {
  PlaneStore rows(store.width(), row_count);
  const std::size_t count = static_cast<std::size_t>(store.width()) * static_cast<std::size_t>(row_count);
  std::vector<float> x(count), y(count), z(count);
  store.read_rows(first_row, row_count, {x.data(), y.data(), z.data()});
  rows.write_rows(0, row_count, {x.data(), y.data(), z.data()});
  return rows;
}

}  // namespace

MovmfFit::MovmfFit(Device& device, const MapInputs& map, const MovmfSettings& settings, const MipSchedule& schedule,
                   const BakePlan& plan, RowOrigin& rows, ChooseStart choose_start, FitReport& report,
                   Progress* progress)
    : device_(device),
      map_(map),
      settings_(settings),
      schedule_(schedule),
      plan_(plan),
      rows_(rows),
      choose_start_(std::move(choose_start)),
      report_(report),
      progress_(progress),
      em_step_(device, settings, schedule.weighted),
      map_width_(map.normals->width()),
      map_height_(map.normals->height()) {
  for (int l = settings.first_level; l < mip_level_count(map_width_, map_height_); ++l)
    report_.levels.push_back({l, mip_level_size(map_width_, l), mip_level_size(map_height_, l), 0.0, 0});
}

LevelShape MovmfFit::shape_of(const LevelSchedule& level) const {
  const auto width = static_cast<std::size_t>(level.fit.width);
  return {level.level,
          level.fit.height,
          lobe_count() * width * sizeof(MultumVmfLobe),
          feature_planes() * width * sizeof(glm::vec3),
          is_refined(level, settings_),
          level.level > std::max(1, settings_.first_level)};
}

// Reads all normals once for all coarse texels.
void MovmfFit::read_coarse_normals(FitMethod method) {
  if (coarse_.is_read || (method != FitMethod::kBinned && method != FitMethod::kChunks)) return;
  const Stopwatch stopwatch;
  const std::uint64_t launches_before = device_.launch_total();
  progress_stage(progress_, "bin normals");
  coarse_.is_read = true;
  coarse_.on_device = map_on_device(device_, *map_.normals, map_.features.rgb_planes);
  coarse_.binned = bin_levels(device_, *map_.normals, map_.features.rgb_planes, schedule_, settings_.representation,
                              plan_.bin_rows, coarse_.on_device ? &*coarse_.on_device : nullptr, map_.spill, progress_);
  report_.binning_seconds = stopwatch.seconds();
  report_.binning_launches = device_.launch_total() - launches_before;
}

void MovmfFit::fit(const LevelSchedule& level) {
  const LevelShape shape = shape_of(level);
  const LevelTask task = rows_.begin(shape);
  kept_ = task.kept;
  if (task.rows_there > 0) hand_over_there(level, shape, task.rows_there);
  if (task.fitted.begin < task.fitted.end) {
    const bool has_parent = level.fit.parent_width > 0 && settings_.aligned_start;
    if (!has_parent && !rows_.range(level.level)) rows_.start_from(parentless_start(level));
    read_coarse_normals(level.method);
    progress_stage(progress_, fmt::format("fit level {}", level.level));
    const Stopwatch stopwatch;
    const double zero_seconds = zero_seconds_;
    const std::uint64_t launches_before = device_.launch_total(), zero_launches = zero_launches_;
    BandPlan band = plan_.levels.at(level.level);
    band.band_rows = std::min(band.band_rows, task.fitted.end - task.fitted.begin);
    LevelFit(device_, em_step_, level, settings_, map_, coarse_, rows_, task.fitted, band, progress_)
        .run([&](const FittedRows& rows) { hand_over(level, rows, false); });
    LevelReport& report = report_of(level.level);
    report.seconds = stopwatch.seconds() - (zero_seconds_ - zero_seconds);
    report.launches = device_.launch_total() - launches_before - (zero_launches_ - zero_launches);
  }
  handing_over_.wait();
  rows_.end();
  coarse_.binned.erase(level.level);
}

void MovmfFit::fit_single_texel() {
  hand_over_finest({0, 1, {0}});
  advance({0, 1}, map_height_);
}

// Passes rows [0, row_count) of a level to the sink, band by band.
void MovmfFit::hand_over_there(const LevelSchedule& level, const LevelShape& shape, int row_count) {
  progress_stage(progress_, fmt::format("gather level {}", level.level));
  const MultumMovmfFit& fit = level.fit;
  const auto ranges = handed_ranges(device_, level, settings_, map_, plan_.levels.at(level.level));
  int band = 1;
  for (const LevelRows& range : ranges) band = std::max(band, std::min(range.end, row_count) - range.begin);
  const auto window = [&](std::size_t planes, std::size_t row_bytes, const char* what) {
    return RowWindow(device_, static_cast<int>(planes), row_bytes / planes, band, what);
  };
  const auto fill = [&](RowPart part, std::size_t row_bytes) {
    return fill_planes(fit.height, row_bytes,
                       [this, part](int first, int count, void* rows) { rows_.read(part, first, count, rows); });
  };
  RowWindow lobes = window(lobe_count(), shape.lobe_row_bytes, "finished rows"), features;
  if (has_features()) features = window(feature_planes(), shape.feature_row_bytes, "features of finished rows");
  std::optional<MapWindow> normals;
  if (makes_level_zero(level.level)) normals.emplace(device_, *map_.normals, 2 * band + 1, "normals");
  for (const auto& [row, end] : ranges) {
    if (row >= row_count) break;
    const int count = std::min(end, row_count) - row;
    lobes.move_to(row, count, fill(RowPart::kStored, shape.lobe_row_bytes));
    if (has_features()) features.move_to(row, count, fill(RowPart::kFeatures, shape.feature_row_bytes));
    FittedRows rows{row, count, &lobes, has_features() ? &features : nullptr, normals ? &*normals : nullptr,
                    fit, &lobes};
    rows.fit.first_row = row;
    rows.fit.window_rows = band;
    if (normals) normals->move_to(2 * row, finest_end(fit, row + count) - 2 * row);
    hand_over(level, rows, true);
  }
}

// Returns the number of rows of level 0 whose parents are in rows of level 1 above `row`.
int MovmfFit::finest_end(const MultumMovmfFit& fit, int row) const { return row == fit.height ? map_height_ : 2 * row; }

// Returns the start of texels without a parent. These are the texels of the coarsest level and, in an unaligned bake,
// of every level.
RowStore MovmfFit::parentless_start(const LevelSchedule& level) {
  const MultumMovmfFit& fit = level.fit;
  const auto width = static_cast<std::size_t>(fit.width);
  RowStore store(fit.height, shape_of(level).lobe_row_bytes, map_.spill);
  std::vector<MultumVmfLobe> row(lobe_count() * width);
  if (fit.parent_width == 0) {
    progress_stage(progress_, "choose a start");
    const std::vector<MultumVmfLobe> starts = choose_start_();
    MULTUM_CHECK(starts.size() == row.size() * static_cast<std::size_t>(fit.height));
    store.write(0, fit.height, starts.data());
    return store;
  }
  for (int y = 0; y < fit.height; ++y) {
    const int first = first_covered_row(fit, y), rows = std::max(1, first_covered_row(fit, y + 1) - first);
    const PlaneStore covered = rows_of(*map_.normals, first, rows);
    for (int x = 0; x < fit.width; ++x) {
      const auto edge = [&](int texel) { return static_cast<int>(std::int64_t{texel} * fit.map_width / fit.width); };
      const std::vector<MultumVmfLobe> lobes = start_lobes(
          farthest_first_lobes(covered, {edge(x), 0, std::max(edge(x) + 1, edge(x + 1)), rows}, settings_.lobe_count),
          settings_.representation, map_.normals->is_shortened());
      for (std::size_t j = 0; j < lobe_count(); ++j) row[j * width + static_cast<std::size_t>(x)] = lobes[j];
    }
    store.write(y, 1, row.data());
  }
  return store;
}

void MovmfFit::hand_over(const LevelSchedule& level, const FittedRows& rows, bool is_there) {
  const std::size_t texels = static_cast<std::size_t>(level.fit.width) * static_cast<std::size_t>(rows.row_count);
  // Leaves the memory uninitialised to save time, because a band takes tens of megabytes.
  auto lobes = std::make_shared_for_overwrite<MultumVmfLobe[]>(lobe_count() * texels);
  rows.lobes->copy_rows(rows.first_row, rows.row_count, lobes.get());
  std::vector<MultumVmfLobe> em_lobes;  // lobes of EM, if they differ from the stored lobes
  if (!is_there && rows.em_lobes != rows.lobes) {
    em_lobes.resize(lobe_count() * texels);
    rows.em_lobes->copy_rows(rows.first_row, rows.row_count, em_lobes.data());
  }
  std::vector<glm::vec3> features(feature_planes() * texels);
  if (has_features()) rows.features->copy_rows(rows.first_row, rows.row_count, features.data());
  std::optional<ZeroRows> finest;
  if (makes_level_zero(level.level)) finest = fit_level_zero(rows);
  const int finest_count = finest ? finest->row_count : 0;
  handing_over_.run(map_.threads, [this, number = level.level, is_there, first_row = rows.first_row,
                                   size = LobeRowsSize{level.fit.width, rows.row_count, settings_.lobe_count,
                                                       settings_.representation, map_.features.has_colours,
                                                       map_.features.weight_count},
                                   lobes = std::move(lobes), em_lobes = std::move(em_lobes),
                                   features = std::move(features), finest = std::move(finest)]() mutable {
    if (!is_there)
      rows_.keep(
          {first_row, size.height, em_lobes.empty() ? lobes.get() : em_lobes.data(), features.data(), lobes.get()});
    if (rows_.sink() == nullptr) return;
    rows_.sink()->add_level(number, first_row,
                            stored_rows(size, lobes.get(), features, settings_.kappa_cap, map_.threads, report_));
    if (finest) hand_over_finest(std::move(*finest));
  });
  const LevelRows done = {rows.first_row, rows.first_row + rows.row_count};
  advance(is_there ? done : common_rows(done, kept_), level.fit.height);
  if (finest_count > 0) advance({2 * rows.first_row, 2 * rows.first_row + finest_count}, map_height_);
}

// For progress, each level counts as many units as the map has texels. The units are distributed evenly among the rows
// of the level.
void MovmfFit::advance(const LevelRows& rows, int height) {
  if (rows.begin >= rows.end) return;
  const std::uint64_t texels = static_cast<std::uint64_t>(map_width_) * static_cast<std::uint64_t>(map_height_);
  const auto until = [&](int row) {
    return texels * static_cast<std::uint64_t>(row) / static_cast<std::uint64_t>(height);
  };
  progress_advance(progress_, until(rows.end) - until(rows.begin));
}

// Fits the rows of level 0 whose parents are `rows` of level 1, while their normals are on the device.
MovmfFit::ZeroRows MovmfFit::fit_level_zero(const FittedRows& rows) {
  const Stopwatch stopwatch;
  const int first = 2 * rows.first_row, below = rows.first_row + rows.row_count;
  ZeroRows out{first, finest_end(rows.fit, below) - first, {}};
  const std::size_t texels = static_cast<std::size_t>(map_width_) * static_cast<std::size_t>(out.row_count);
  DeviceBuffer nearest = device_.make_buffer(texels, "numbers of lobes");
  const MapWindow& normals = *rows.normals;
  if (!level_zero_kernel_.is_built()) {
    const ProgramChoice program = level_zero_program(device_, schedule_, settings_);
    level_zero_kernel_ = device_.kernel(program.file, "movmf_level_zero", program.variant);
  }
  const auto width = static_cast<std::size_t>(map_width_),
             per_item = static_cast<std::size_t>(device_.shape().vector_width);
  level_zero_kernel_.launch({static_cast<std::size_t>(out.row_count) * ((width + per_item - 1) / per_item)}, normals[0],
                            normals[1], normals[2], rows.lobes->buffer(), nearest, rows.fit,
                            settings_.aligned_start ? 1 : 0, first - normals.first_row(), first, out.row_count);
  ++zero_launches_;
  out.lobe.resize(texels);
  device_.read(nearest, out.lobe.data(), texels);
  zero_seconds_ += stopwatch.seconds();
  report_of(0).seconds = zero_seconds_;
  report_of(0).launches = zero_launches_;
  return out;
}

void MovmfFit::hand_over_finest(ZeroRows rows) {
  MovmfFinest out =
      finest_rows(*map_.normals, map_.features, settings_.representation, rows.first_row, rows.row_count, map_.threads);
  out.lobe = std::move(rows.lobe);
  report_.lobe_count_total += lobe_count() * out.lobe.size();
  rows_.sink()->add_finest(rows.first_row, std::move(out));
}

void prepare_fit(Device& device, const MipSchedule& schedule, const MovmfSettings& settings, bool has_features) {
  if (schedule.levels.empty()) return;  // a single texel
  std::vector<ProgramChoice> programs =
      MovmfEmStep(device, settings, schedule.weighted).programs(schedule, has_features);
  if (settings.first_level == 0) programs.push_back(level_zero_program(device, schedule, settings));
  for (const ProgramChoice& program : binning_programs(schedule, settings.representation, device.shape()))
    programs.push_back(program);
  device.prepare(programs);
}

}  // namespace multum
