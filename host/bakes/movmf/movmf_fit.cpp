// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/movmf_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "host/bakes/movmf/gathered_shards.h"
#include "host/bakes/movmf/lobe_rows.h"
#include "host/bakes/movmf/movmf_binning.h"
#include "host/bakes/movmf/movmf_level_fit.h"
#include "host/bakes/movmf/movmf_start.h"
#include "host/bakes/pyramid/finest_rows.h"
#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/background_task.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

ProgramChoice level_zero_program(const MipSchedule& schedule, const MovmfSettings& settings) {
  return {"movmf_level_zero",
          {settings.lobe_count, 1, schedule.weighted, lobe_family(settings.representation).is_planar}};
}

class MovmfFitter {
 public:
  MovmfFitter(Device& device, const MovmfBakeInputs& inputs, const std::vector<MultumVmfLobe>& top_start,
              const MovmfSettings& settings, const MipSchedule& schedule, const BakePlan& plan, MovmfSink& sink,
              FitReport& report, Progress* progress)
      : device_(device),
        inputs_(inputs),
        top_start_(top_start),
        settings_(settings),
        schedule_(schedule),
        plan_(plan),
        sink_(sink),
        report_(report),
        progress_(progress),
        em_step_(device, settings, schedule.weighted),
        map_width_(inputs.normals->width()),
        map_height_(inputs.normals->height()) {
    for (int l = settings.first_level; l < mip_level_count(map_width_, map_height_); ++l)
      report_.levels.push_back({l, mip_level_size(map_width_, l), mip_level_size(map_height_, l), 0.0, 0});
  }

  void bin() {
    const Stopwatch stopwatch;
    const std::uint64_t launches_before = device_.launch_total();
    progress_stage(progress_, "bin normals");
    on_device_ = map_on_device(device_, *inputs_.normals, inputs_.features.rgb_planes);
    binned_ = bin_levels(device_, *inputs_.normals, inputs_.features.rgb_planes, schedule_, settings_.representation,
                         plan_.bin_rows, on_device_ ? &*on_device_ : nullptr, plan_.spill, progress_);
    report_.binning_seconds = stopwatch.seconds();
    report_.binning_launches = device_.launch_total() - launches_before;
  }

  void fit(const LevelSchedule& level) {
    if (inputs_.gathered != nullptr) {
      hand_over_gathered(level);
      return;
    }
    progress_stage(progress_, fmt::format("fit level {}", level.level));
    const Stopwatch stopwatch;
    const double zero_seconds = zero_seconds_;
    const std::uint64_t launches_before = device_.launch_total(), zero_launches = zero_launches_;
    LevelInputs inputs{inputs_};
    inputs.on_device = on_device_ ? &*on_device_ : nullptr;
    const auto binned = binned_.find(level.level);
    if (binned != binned_.end()) inputs.binned = &binned->second;
    LevelStore store = open_store(level);
    const int rows_done = replay(level, store);
    if (rows_done == level.fit.height) {
      handing_over_.wait();
      keep(level, std::move(store), {});
      return;
    }
    const bool has_parent = level.fit.parent_width > 0 && settings_.aligned_start;
    if (has_parent) inputs.parent = &coarser();
    std::optional<RowStore> there;  // lobes before the fit
    TexelRange range{};
    if (inputs_.region != nullptr) {
      range = inputs_.region->range(level.level);
      inputs.range = &range;
      inputs.kept = &there.emplace(inputs_.region->kept(level.level));
    } else if (!has_parent) {
      inputs.start = &there.emplace(parentless_start(level));
    }
    inputs.rows = LevelRows{rows_done, level.fit.height};
    LevelFit(device_, em_step_, level, settings_, inputs, plan_.levels.at(level.level), progress_)
        .run([&](const FittedRows& rows) { hand_over(level, rows, store); });
    handing_over_.wait();
    keep(level, std::move(store), std::move(there));
    binned_.erase(level.level);
    LevelReport& report = report_of(level.level);
    report.seconds = stopwatch.seconds() - (zero_seconds_ - zero_seconds);
    report.launches = device_.launch_total() - launches_before - (zero_launches_ - zero_launches);
  }

  // The levels of a share, whose rows its writer takes.
  void fit_shard() {
    const ShardPlan shard = plan_shard(schedule_, settings_, inputs_.shard->shard);
    if (inputs_.shard->shard.index == 0) {
      bin();
      for (const LevelSchedule& level : schedule_.levels)
        if (level.level >= shard.coarse_from) fit(level);
      return;
    }
    for (const LevelSchedule& level : schedule_.levels)
      if (level.level == shard.coarse_from) coarser_ = rows_of_share(level);
      else if (level.level < shard.coarse_from)
        fit_band(level, shard.kept.at(level.level), shard.fitted.at(level.level));
  }

  // A map of one texel has no level 1.
  void fit_single_texel() {
    hand_over_finest({0, 1, {0}});
    advance(0, 1, map_height_);
  }

 private:
  std::size_t lobe_count() const { return static_cast<std::size_t>(settings_.lobe_count); }
  bool has_features() const { return !inputs_.features.empty(); }
  // Planes of features, [triple][lobe].
  std::size_t feature_planes() const { return lobe_count() * inputs_.features.rgb_planes.size(); }
  LevelReport& report_of(int level) { return report_.levels[static_cast<std::size_t>(level - settings_.first_level)]; }

  // Where a level's lobes go: to the checkpoint, or to a store of its own where a finer level needs them.
  struct LevelStore {
    BakeCheckpoint::Level* kept = nullptr;
    std::optional<RowStore> own;
  };

  std::size_t row_bytes(const LevelSchedule& level) const {
    return lobe_count() * static_cast<std::size_t>(level.fit.width) * sizeof(MultumVmfLobe);
  }

  std::size_t feature_row_bytes(const LevelSchedule& level) const {
    return feature_planes() * static_cast<std::size_t>(level.fit.width) * sizeof(glm::vec3);
  }

  LevelStore open_store(const LevelSchedule& level) {
    LevelStore store;
    const bool is_parent = level.level > std::max(1, settings_.first_level);
    if (inputs_.checkpoint != nullptr && (is_parent || inputs_.checkpoint_has_finest))
      store.kept = &inputs_.checkpoint->open_level(
          level.level, level.fit.height, {row_bytes(level), feature_row_bytes(level), is_refined(level, settings_)});
    else if (is_parent) store.own.emplace(level.fit.height, row_bytes(level), plan_.spill);
    return store;
  }

  // The level that was fitted last is the next one's parent; of a region what is kept, with what was fitted written
  // over.
  void keep(const LevelSchedule& level, LevelStore store, std::optional<RowStore> there) {
    if (inputs_.region != nullptr) {
      coarser_ = std::move(there);
      // Rows that were handed over hold what was fitted beside what was kept.
      const TexelRange range = inputs_.region->range(level.level);
      std::vector<unsigned char> row(row_bytes(level));
      for (int y = range.y0; store.own && y < range.y1; ++y) {
        store.own->read(y, 1, row.data());
        coarser_->write(y, 1, row.data());
      }
    } else if (store.own) {
      coarser_ = std::move(store.own);
    }
    coarser_kept_ = store.kept;
  }

  // The level as the coarse share has it.
  RowStore rows_of_share(const LevelSchedule& level) {
    RowStore store(level.fit.height, row_bytes(level), plan_.spill);
    int count = 0;
    inputs_.shard->coarse->read(level.level, [&](const ShardReader::Rows& rows) {
      if (rows.lobe_row_bytes != row_bytes(level) || rows.first_row != count ||
          rows.row_count > level.fit.height - count)
        throw Error(ErrorCode::kEnvironment,
                    "the share of coarse levels has other rows than it should; --force makes it");
      store.write(rows.first_row, rows.row_count, rows.lobes);
      count += rows.row_count;
    });
    if (count != level.fit.height)
      throw Error(ErrorCode::kEnvironment, "the share of coarse levels has not all of its rows; --force makes it");
    return store;
  }

  void fit_band(const LevelSchedule& level, const LevelRows& kept, const LevelRows& fitted) {
    progress_stage(progress_, fmt::format("fit level {}", level.level));
    const Stopwatch stopwatch;
    LevelInputs inputs{inputs_};
    inputs.parent = &*coarser_;
    inputs.rows = fitted;
    LevelStore store = open_store(level);
    // Windows reach beyond what is fitted, and read there what nobody wrote.
    if (store.own) store.own->write(level.fit.height - 1, 1, std::vector<unsigned char>(row_bytes(level)).data());
    BandPlan band = plan_.levels.at(level.level);
    band.band_rows = std::min(band.band_rows, fitted.end - fitted.begin);
    LevelFit(device_, em_step_, level, settings_, inputs, band, progress_).run([&](const FittedRows& rows) {
      hand_over_to_share(level, rows, store, kept);
    });
    coarser_ = std::move(store.own);
    report_of(level.level).seconds = stopwatch.seconds();
  }

  // Of rows that were fitted, those that are kept to the share, and all to the store that the next level grows from.
  void hand_over_to_share(const LevelSchedule& level, const FittedRows& rows, LevelStore& store,
                          const LevelRows& kept) {
    const std::size_t lobe_bytes = row_bytes(level), feature_bytes = feature_row_bytes(level);
    const auto count = static_cast<std::size_t>(rows.row_count);
    // Not set to 0: tens of megabytes a band.
    const auto lobes = std::make_unique_for_overwrite<unsigned char[]>(lobe_bytes * count),
               features = std::make_unique_for_overwrite<unsigned char[]>(feature_bytes * count);
    rows.lobes->copy_rows(rows.first_row, rows.row_count, lobes.get());
    if (has_features()) rows.features->copy_rows(rows.first_row, rows.row_count, features.get());
    if (store.own)
      for_each_piece(rows.first_row, rows.row_count, level.fit.height, [&](int first, int piece, int at) {
        store.own->write(first, piece, lobes.get() + lobe_bytes * static_cast<std::size_t>(at));
      });
    const LevelRows own = {std::max(rows.first_row, kept.begin), std::min(rows.first_row + rows.row_count, kept.end)};
    if (own.begin >= own.end) return;
    const auto at = static_cast<std::size_t>(own.begin - rows.first_row);
    inputs_.shard->writer->add_rows(level.level, own.begin, own.end - own.begin, lobe_bytes,
                                    lobes.get() + lobe_bytes * at, feature_bytes, features.get() + feature_bytes * at);
    advance(own.begin, own.end - own.begin, level.fit.height);
  }

  RowStore& coarser() { return coarser_kept_ != nullptr ? coarser_kept_->lobes : *coarser_; }

  // Hands rows over that a killed bake had done. Returns how many.
  int replay(const LevelSchedule& level, LevelStore& store) {
    if (store.kept == nullptr || store.kept->rows_done == 0) return 0;
    const int done = store.kept->rows_done;
    hand_over_done(level, done, store, fill_planes(store.kept->stored()),
                   store.kept->features ? fill_planes(*store.kept->features) : nullptr);
    return done;
  }

  // Rows that others have fitted.
  void hand_over_gathered(const LevelSchedule& level) {
    progress_stage(progress_, fmt::format("gather level {}", level.level));
    const int height = level.fit.height;
    LevelStore store;
    const auto features = [&](int first, int count, void* rows) {
      inputs_.gathered->read_features(level.level, first, count, rows);
    };
    hand_over_done(level, height, store,
                   fill_planes(height, row_bytes(level),
                               [&](int first, int count, void* rows) {
                                 inputs_.gathered->read_lobes(level.level, first, count, rows);
                               }),
                   has_features() ? fill_planes(height, feature_row_bytes(level), features) : nullptr);
    handing_over_.wait();
  }

  // The first `done` rows of a level, a band at a time.
  void hand_over_done(const LevelSchedule& level, int done, LevelStore& store, const RowWindow::Fill& fill_lobes,
                      const RowWindow::Fill& fill_features) {
    const bool with_normals = level.level == 1 && settings_.first_level == 0;
    const MultumMovmfFit& fit = level.fit;
    const auto ranges = handed_ranges(device_, level, settings_, {inputs_}, plan_.levels.at(level.level));
    int band = 1;
    for (const LevelRows& range : ranges) band = std::max(band, std::min(range.end, done) - range.begin);
    RowWindow lobes(device_, settings_.lobe_count, row_bytes(level) / lobe_count(), band, "finished rows");
    RowWindow features;
    if (has_features())
      features = RowWindow(device_, static_cast<int>(feature_planes()),
                           static_cast<std::size_t>(fit.width) * sizeof(glm::vec3), band, "features of finished rows");
    std::optional<MapWindow> normals;
    if (with_normals) normals.emplace(device_, *inputs_.normals, 2 * band + 1, "normals");
    for (const auto& [row, end] : ranges) {
      if (row >= done) break;
      const int count = std::min(end, done) - row;
      lobes.move_to(row, count, fill_lobes);
      if (has_features()) features.move_to(row, count, fill_features);
      FittedRows rows{row, count, &lobes, has_features() ? &features : nullptr, normals ? &*normals : nullptr,
                      fit, &lobes};
      rows.fit.first_row = row;
      rows.fit.window_rows = band;
      if (normals) normals->move_to(2 * row, finest_end(fit, row + count) - 2 * row);
      hand_over(level, rows, store, true);
    }
  }

  // One past the last row of level 0 whose parents are the rows of level 1 above `row`.
  int finest_end(const MultumMovmfFit& fit, int row) const { return row == fit.height ? map_height_ : 2 * row; }

  // Texels without a parent: the coarsest level, and every level of an unaligned bake.
  RowStore parentless_start(const LevelSchedule& level) const {
    const MultumMovmfFit& fit = level.fit;
    const auto width = static_cast<std::size_t>(fit.width);
    RowStore store(fit.height, row_bytes(level), plan_.spill);
    std::vector<MultumVmfLobe> row(lobe_count() * width);
    for (int y = 0; y < fit.height; ++y) {
      const int first = first_covered_row(fit, y), rows = std::max(1, first_covered_row(fit, y + 1) - first);
      const PlaneStore covered = fit.parent_width == 0 ? PlaneStore(0, 0) : rows_of(*inputs_.normals, first, rows);
      for (int x = 0; x < fit.width; ++x) {
        const auto edge = [&](int texel) { return static_cast<int>(std::int64_t{texel} * fit.map_width / fit.width); };
        const std::vector<MultumVmfLobe> lobes =
            fit.parent_width == 0
                ? top_start_
                : start_lobes(farthest_first_lobes(covered, {edge(x), 0, std::max(edge(x) + 1, edge(x + 1)), rows},
                                                   settings_.lobe_count),
                              settings_.representation, inputs_.normals->is_shortened());
        for (std::size_t j = 0; j < lobe_count(); ++j) row[j * width + static_cast<std::size_t>(x)] = lobes[j];
      }
      store.write(y, 1, row.data());
    }
    return store;
  }

  static PlaneStore rows_of(const PlaneStore& store, int first_row, int row_count) {
    PlaneStore rows(store.width(), row_count);
    const std::size_t count = static_cast<std::size_t>(store.width()) * static_cast<std::size_t>(row_count);
    std::vector<float> x(count), y(count), z(count);
    store.read_rows(first_row, row_count, {x.data(), y.data(), z.data()});
    rows.write_rows(0, row_count, {x.data(), y.data(), z.data()});
    return rows;
  }

  void hand_over(const LevelSchedule& level, const FittedRows& rows, LevelStore& store, bool is_kept = false) {
    if (inputs_.shard != nullptr) {
      hand_over_to_share(level, rows, store, {0, level.fit.height});
      return;
    }
    const std::size_t texels = static_cast<std::size_t>(level.fit.width) * static_cast<std::size_t>(rows.row_count);
    // Not set to 0: tens of megabytes a band.
    auto lobes = std::make_shared_for_overwrite<MultumVmfLobe[]>(lobe_count() * texels);
    rows.lobes->copy_rows(rows.first_row, rows.row_count, lobes.get());
    const bool keeps = store.kept != nullptr && !is_kept;
    std::vector<MultumVmfLobe> em_lobes;  // where they are not what is stored
    if ((store.own || keeps) && rows.em_lobes != rows.lobes) {
      em_lobes.resize(lobe_count() * texels);
      rows.em_lobes->copy_rows(rows.first_row, rows.row_count, em_lobes.data());
    }
    if (store.own) store.own->write(rows.first_row, rows.row_count, em_lobes.empty() ? lobes.get() : em_lobes.data());
    std::vector<glm::vec3> features(feature_planes() * texels);
    if (has_features()) rows.features->copy_rows(rows.first_row, rows.row_count, features.data());
    std::optional<FinestRows> finest;
    if (level.level == 1 && settings_.first_level == 0) finest = fit_level_zero(rows);
    const int finest_count = finest ? finest->row_count : 0;
    handing_over_.run(inputs_.threads, [this, number = level.level, keeps, first_row = rows.first_row,
                                        size = LobeRowsSize{level.fit.width, rows.row_count, settings_.lobe_count,
                                                            settings_.representation, inputs_.features.has_colours,
                                                            inputs_.features.weight_count},
                                        lobes = std::move(lobes), em_lobes = std::move(em_lobes),
                                        features = std::move(features), finest = std::move(finest)]() mutable {
      const MultumVmfLobe* parents = em_lobes.empty() ? lobes.get() : em_lobes.data();
      if (keeps) inputs_.checkpoint->add_rows(number, size.height, {parents, features.data(), lobes.get()});
      sink_.add_level(number, first_row,
                      stored_rows(size, lobes.get(), features, settings_.kappa_cap, inputs_.threads, report_));
      if (finest) hand_over_finest(std::move(*finest));
    });
    advance(rows.first_row, rows.row_count, level.fit.height);
    if (finest_count > 0) advance(2 * rows.first_row, finest_count, map_height_);
  }

  // Each level counts as much as the map has texels, spread over its rows.
  void advance(int first_row, int row_count, int height) {
    const std::uint64_t texels = static_cast<std::uint64_t>(map_width_) * static_cast<std::uint64_t>(map_height_);
    const auto until = [&](int row) {
      return texels * static_cast<std::uint64_t>(row) / static_cast<std::uint64_t>(height);
    };
    progress_advance(progress_, until(first_row + row_count) - until(first_row));
  }

  struct FinestRows {
    int first_row, row_count;
    std::vector<std::uint8_t> lobe;
  };

  // The rows of level 0 whose parents are `rows` of level 1, while their normals are on the device.
  FinestRows fit_level_zero(const FittedRows& rows) {
    const Stopwatch stopwatch;
    const int first = 2 * rows.first_row, below = rows.first_row + rows.row_count;
    FinestRows out{first, finest_end(rows.fit, below) - first, {}};
    const std::size_t texels = static_cast<std::size_t>(map_width_) * static_cast<std::size_t>(out.row_count);
    DeviceBuffer nearest = device_.make_buffer(texels, "numbers of lobes");
    const MapWindow& normals = *rows.normals;
    if (!level_zero_kernel_.is_built()) {
      const ProgramChoice program = level_zero_program(schedule_, settings_);
      level_zero_kernel_ = device_.kernel(program.file, "movmf_level_zero", program.variant);
    }
    level_zero_kernel_.launch({texels}, normals[0], normals[1], normals[2], rows.lobes->buffer(), nearest, rows.fit,
                              settings_.aligned_start ? 1 : 0, first - normals.first_row(), first, out.row_count);
    ++zero_launches_;
    out.lobe.resize(texels);
    device_.read(nearest, out.lobe.data(), texels);
    zero_seconds_ += stopwatch.seconds();
    report_of(0).seconds = zero_seconds_;
    report_of(0).launches = zero_launches_;
    return out;
  }

  void hand_over_finest(FinestRows rows) {
    MovmfFinest out = finest_rows(*inputs_.normals, inputs_.features, settings_.representation, rows.first_row,
                                  rows.row_count, inputs_.threads);
    out.lobe = std::move(rows.lobe);
    report_.lobe_count_total += lobe_count() * out.lobe.size();
    sink_.add_finest(rows.first_row, std::move(out));
  }

  Device& device_;
  const MovmfBakeInputs& inputs_;
  const std::vector<MultumVmfLobe>& top_start_;
  const MovmfSettings settings_;
  const MipSchedule& schedule_;
  const BakePlan& plan_;
  MovmfSink& sink_;
  FitReport& report_;
  Progress* progress_;
  MovmfEmStep em_step_;
  Kernel level_zero_kernel_;
  const int map_width_, map_height_;
  std::optional<MapWindows> on_device_;  // the whole map, where the device has room for it
  std::map<int, BinnedLevel> binned_;
  // The level before, rows [lobe][column]: in the checkpoint, or here.
  BakeCheckpoint::Level* coarser_kept_ = nullptr;
  std::optional<RowStore> coarser_;
  double zero_seconds_ = 0.0;
  std::uint64_t zero_launches_ = 0;
  BackgroundTask handing_over_;  // the last rows, to the sink
};

}  // namespace

void prepare_fit(Device& device, const MipSchedule& schedule, const MovmfSettings& settings, bool has_features) {
  if (schedule.levels.empty()) return;  // a single texel
  std::vector<ProgramChoice> programs =
      MovmfEmStep(device, settings, schedule.weighted).programs(schedule, has_features);
  if (settings.first_level == 0) programs.push_back(level_zero_program(schedule, settings));
  for (const ProgramChoice& program : binning_programs(schedule, settings.representation, device.shape()))
    programs.push_back(program);
  device.prepare(programs);
}

void fit_movmf(Device& device, const MovmfBakeInputs& inputs, const std::vector<MultumVmfLobe>& top_start,
               const MovmfSettings& settings, const MipSchedule& schedule, const BakePlan& plan, MovmfSink& sink,
               FitReport& report, Progress* progress) {
  MovmfFitter fitter(device, inputs, top_start, settings, schedule, plan, sink, report, progress);
  if (inputs.shard != nullptr) {
    fitter.fit_shard();
    return;
  }
  if (inputs.gathered == nullptr) fitter.bin();
  for (const LevelSchedule& level : schedule.levels) fitter.fit(level);
  if (schedule.levels.empty() && settings.first_level == 0) fitter.fit_single_texel();
}

}  // namespace multum
