// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/movmf_bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <span>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/accuracy/models/movmf_model.h"
#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/movmf/movmf_average.h"
#include "host/bakes/movmf/movmf_fit.h"
#include "host/bakes/movmf/movmf_start.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/run_times.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

// Collects the rows of a bake in a whole mipmap.
class MovmfMipmapSink : public MovmfSink {
 public:
  MovmfMipmapSink(const PlaneStore& normals, const MovmfSettings& settings, const FeaturePlanes& features) {
    mipmap_.header.representation = settings.representation;
    mipmap_.header.first_level = settings.first_level;
    mipmap_.header.weight_count = features.weight_count;
    mipmap_.header.has_roughness = normals.is_shortened();
    for (int l = 0; l < mip_level_count(normals.width(), normals.height()); ++l) {
      MovmfLevel& level = mipmap_.levels.emplace_back();
      level.width = mip_level_size(normals.width(), l);
      level.height = mip_level_size(normals.height(), l);
      level.lobes.resize(static_cast<std::size_t>(settings.lobe_count));
      if (features.has_colours) level.colours.resize(level.lobes.size());
      if (features.weight_count > 0) level.weights.resize(level.lobes.size());
    }
  }

  void add_level(int level, int, MovmfLevel rows) override {
    MovmfLevel& to = mipmap_.levels[static_cast<std::size_t>(level)];
    for (std::size_t j = 0; j < to.lobes.size(); ++j)
      to.lobes[j].insert(to.lobes[j].end(), rows.lobes[j].begin(), rows.lobes[j].end());
    for (std::size_t j = 0; j < to.colours.size(); ++j)
      to.colours[j].insert(to.colours[j].end(), rows.colours[j].begin(), rows.colours[j].end());
    for (std::size_t j = 0; j < to.weights.size(); ++j)
      to.weights[j].insert(to.weights[j].end(), rows.weights[j].begin(), rows.weights[j].end());
  }
  void add_finest(int first_row, MovmfFinest rows) override {
    add_level(0, first_row, expand(rows, mipmap_.lobe_count()));
  }

  MovmfMipmap take() { return std::move(mipmap_); }

 private:
  MovmfMipmap mipmap_;
};

// The largest side of the levels of the proxy map that are compared. On finer levels, a texel has too few normals.
constexpr int kComparedSideMax = 16;

// Returns `count` copies of the map below each other.
NormalMap copies_of(const NormalMap& map, int count) {
  NormalMap copies = map;
  copies.height *= count;
  for (int i = 1; i < count; ++i) {
    copies.x.insert(copies.x.end(), map.x.begin(), map.x.end());
    copies.y.insert(copies.y.end(), map.y.begin(), map.y.end());
    copies.z.insert(copies.z.end(), map.z.begin(), map.z.end());
  }
  return copies;
}

// Bakes a small proxy map from several starts. The coarse levels of a proxy map have fewer texels than a processor has
// lanes, so all starts are tried at once, each on a copy of the proxy map.
class StartTrial {
 public:
  StartTrial(Device& device, const NormalMap& proxy, const MovmfSettings& settings, const MipSchedule& of_map)
      : device_(device), proxy_(proxy), planes_(planes_of(proxy)), settings_(settings), is_weighted_(of_map.weighted) {}

  // Builds the pyramid from each candidate and returns its error at and between texel centres. A start is good if it
  // leads to low errors on finer levels. These errors can be predicted neither from the likelihood of the start nor
  // from its own error. On the four-quarter map with 6 lobes, for example, the best start ranked 14th by its own error.
  std::vector<double> errors_from(const std::vector<std::vector<MultumVmfLobe>>& starts) const {
    AccuracySettings accuracy;
    accuracy.samples_per_level = 0;
    accuracy.footprints_per_octave = 0;
    accuracy.threads = 1;  // too little work for several threads
    accuracy.directions = {{{0.0, 0.0, 1.0}}, spread_half_vectors(64), {}};
    while (std::max(mip_level_size(planes_.width(), accuracy.first_level),
                    mip_level_size(planes_.height(), accuracy.first_level)) > kComparedSideMax)
      ++accuracy.first_level;
    // Copies support neither level 1 (movmf_choose.cl) nor sides that are not powers of two.
    const bool at_once = accuracy.first_level >= 2 && proxy_.width == proxy_.height &&
                         std::has_single_bit(static_cast<unsigned>(proxy_.width));
    const std::size_t batch = at_once ? starts.size() : 1;
    std::vector<MovmfMipmap> mipmaps;
    for (std::size_t first = 0; first < starts.size(); first += batch)
      add_pyramids(std::span(starts).subspan(first, batch), accuracy.first_level, mipmaps);
    std::vector<double> errors;
    for (const std::vector<AccuracyRow>& rows : measure_each(device_, mipmaps, planes_, accuracy)) {
      double& error = errors.emplace_back(0.0);  // logarithm of the product of the errors, so that no BRDF or level
                                                 // dominates
      for (const AccuracyRow& row : rows)
        if (row.brdf != AccuracyBrdf::lambert()) error += std::log(row.error + 0.005);
    }
    return errors;
  }

 private:
  // Appends a pyramid for each start. Finer levels than `finest` remain empty, because no level depends on them.
  void add_pyramids(std::span<const std::vector<MultumVmfLobe>> starts, int finest,
                    std::vector<MovmfMipmap>& mipmaps) const {
    const int count = static_cast<int>(starts.size());
    const NormalMap copied = copies_of(proxy_, count);
    const PlaneStore copies = planes_of(copied);  // reads the memory of `copied`
    const MapInputs map{&copies};
    MipSchedule schedule = make_mip_schedule(planes_, settings_, is_weighted_);
    if (count > 1) make_copies(schedule, count);
    BakePlan plan = make_bake_plan(schedule, settings_, map, device_.shape());
    std::vector<MultumVmfLobe> lobes;
    for (const std::vector<MultumVmfLobe>& start : starts) lobes.insert(lobes.end(), start.begin(), start.end());
    // A texel's neighbours in its copy may be farther away than the rows of a band.
    for (const LevelSchedule& level : schedule.levels) plan.levels.at(level.level).band_rows = level.fit.height;
    FitReport ignored;
    MovmfMipmapSink sink(copies, settings_, {});
    RowOrigin rows(&sink, map.spill);
    MovmfFit fit(
        device_, map, settings_, schedule, plan, rows, [&] { return lobes; }, ignored, nullptr);
    for (const LevelSchedule& level : schedule.levels)
      if (level.level >= finest) fit.fit(level);
    const MovmfMipmap fitted = sink.take();
    for (std::size_t c = 0; c < starts.size(); ++c) {
      MovmfMipmap& mipmap = mipmaps.emplace_back(MovmfMipmapSink(planes_, settings_, {}).take());
      for (std::size_t l = static_cast<std::size_t>(finest); l < mipmap.levels.size(); ++l) {
        MovmfLevel& level = mipmap.levels[l];
        const std::size_t texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
        for (std::size_t j = 0; j < level.lobes.size(); ++j) {
          const auto begin = fitted.levels[l].lobes[j].begin() + static_cast<std::ptrdiff_t>(c * texels);
          level.lobes[j].assign(begin, begin + static_cast<std::ptrdiff_t>(texels));
        }
      }
    }
  }

  Device& device_;
  const NormalMap& proxy_;
  const PlaneStore planes_;
  const MovmfSettings settings_;
  const bool is_weighted_;
};

// Returns candidates for the map. If there is a StartMemory, it keeps them for all settings with the same number of
// lobes.
StartCandidates find_candidates(const PlaneStore& normals, const StartSearch& search, StartMemory* memory) {
  if (memory != nullptr)
    if (const StartCandidates* known = memory->candidates(search.lobe_count, search.kappa_max)) return *known;
  const RunClock clock;
  StartCandidates found{start_candidates(normals, search), {}};
  found.time = clock.time();
  return memory == nullptr ? found : memory->remember(search.lobe_count, search.kappa_max, std::move(found));
}

// Returns the candidate with the best pyramid on a proxy map. If `is_timed` is true, the kernels are loaded before
// timing starts.
ChosenStart try_candidates(Device& device, const NormalMap& proxy, const MovmfSettings& whole,
                           const MipSchedule& schedule, const std::vector<std::vector<MultumVmfLobe>>& candidates,
                           bool is_timed) {
  device.prepare({MovmfModel::program(device, whole.representation, whole.lobe_count, whole.first_level)});
  const StartTrial start_trial(device, proxy, whole, schedule);  // uses the kernels of the map, so that no others are
                                                                 // built
  if (is_timed) start_trial.errors_from({candidates.front()});
  const RunClock clock([&device] { return device.timed_seconds(); });
  const std::vector<double> errors = start_trial.errors_from(candidates);
  ChosenStart chosen;
  chosen.start = candidates[static_cast<std::size_t>(std::min_element(errors.begin(), errors.end()) - errors.begin())];
  chosen.tried = static_cast<int>(candidates.size());
  chosen.time = clock.time();
  return chosen;
}

// Settings for baking the proxy map.
MovmfSettings trial_settings(const MovmfSettings& settings, const NormalMap& proxy) {
  MovmfSettings whole = settings;
  whole.refine = false;   // refinement is off, because the start affects only the result of EM
  whole.first_level = 0;  // a level of the proxy map, which has fewer levels than the map
  // If the finest levels are not requested, their kernels are not needed either.
  while (settings.first_level > 0 && std::max(mip_level_size(proxy.width, whole.first_level),
                                              mip_level_size(proxy.height, whole.first_level)) > kComparedSideMax)
    ++whole.first_level;
  return whole;
}

ChosenStart search_start(Device& device, const PlaneStore& normals, const MovmfSettings& settings,
                         const MipSchedule& schedule, StartMemory* memory, FitReport& report) {
  constexpr int kProxySide = 64;
  const StartSearch search{settings.lobe_count, settings.kappa_cap, 1, 2};
  const NormalMap proxy = sample_proxy_map(normals, kProxySide, search.seed);
  const MovmfSettings whole = trial_settings(settings, proxy);
  if (memory != nullptr)
    if (const ChosenStart* known = memory->chosen(whole)) {
      report.start_remembered = known->time;
      return *known;
    }
  StartCandidates candidates = find_candidates(normals, search, memory);
  for (std::vector<MultumVmfLobe>& lobes : candidates.starts)
    lobes = start_lobes(std::move(lobes), settings.representation, normals.is_shortened());
  ChosenStart chosen{candidates.starts.front(), 0, {}};
  // Starts can be compared only on levels that grow from the coarsest level.
  if (settings.search_start && settings.aligned_start && candidates.starts.size() > 1)
    chosen = try_candidates(device, proxy, whole, schedule, candidates.starts, memory != nullptr && memory->is_timed());
  chosen.time = chosen.time + candidates.time;
  if (memory != nullptr) memory->remember(whole, chosen);
  return chosen;
}

std::vector<MultumVmfLobe> choose_start(Device& device, const PlaneStore& normals, const MovmfSettings& settings,
                                        const MipSchedule& schedule, StartMemory* memory, FitReport& report) {
  const Stopwatch stopwatch;
  const std::uint64_t launches_before = device.launch_total();
  report.starts_tried = 0;
  if (settings.farthest_start) {
    const TexelRectangle whole_map = {0, 0, normals.width(), normals.height()};
    return start_lobes(farthest_first_lobes(normals, whole_map, settings.lobe_count), settings.representation,
                       normals.is_shortened());
  }
  const ChosenStart chosen = search_start(device, normals, settings, schedule, memory, report);
  report.starts_tried = chosen.tried;
  report.start_launches = device.launch_total() - launches_before;
  report.start_seconds = stopwatch.seconds();
  return chosen.start;
}

}  // namespace

void validate(const MovmfSettings& settings, int map_width, int map_height) {
  validate(settings);
  if (map_width > 32768 || map_height > 32768)
    throw Error(ErrorCode::kInput,
                fmt::format("found a map of {} x {}, expected at most 32768 texels per side", map_width, map_height));
  const int level_max = mip_level_count(map_width, map_height) - 1;
  if (settings.first_level > level_max)
    throw Error(ErrorCode::kUsage,
                fmt::format("--first-level is {}, expected a level from 0 to {} for a map of {} x {}",
                            settings.first_level, level_max, map_width, map_height));
}

void bake_movmf(Device& device, const MapInputs& map, const MovmfSettings& settings, RowOrigin& rows,
                StartMemory* starts, FitReport& report, Progress* progress) {
  const PlaneStore& normals = *map.normals;
  validate(settings, normals.width(), normals.height());
  if (settings.refine && normals.is_shortened())
    throw Error(ErrorCode::kUsage,
                "--refine is given with a roughness map, expected none, because --refine supports only unit normals");
  const FeaturePlanes& features = map.features;
  MULTUM_CHECK(features.all_of_size(normals.width(), normals.height()));
  if (averages_suffice(rows, settings)) {
    if (rows.sink() == nullptr)
      throw Error(ErrorCode::kUsage,
                  "--shard is given with one lobe per texel, which is a plain average that cannot be divided");
    average_movmf(device, map, settings, *rows.sink(), report, progress);
    return;
  }
  const MipSchedule schedule = make_mip_schedule(normals, settings);
  const BakePlan plan = make_bake_plan(schedule, settings, map, device.shape());
  report.plan = plan.to_text(schedule, settings, features.rgb_plane_count());
  prepare_fit(device, schedule, settings, !features.empty());
  const auto start = [&] { return choose_start(device, normals, settings, schedule, starts, report); };
  MovmfFit fit(device, map, settings, schedule, plan, rows, start, report, progress);
  for (const LevelSchedule& level : schedule.levels) fit.fit(level);
  if (schedule.levels.empty() && settings.first_level == 0) fit.fit_single_texel();
  rows.finish();
}

MovmfMipmap bake_movmf(Device& device, const MapInputs& map, const MovmfSettings& settings, FitReport& report,
                       Progress* progress, StartMemory* starts) {
  MovmfMipmapSink sink(*map.normals, settings, map.features);
  RowOrigin rows(&sink, map.spill);
  bake_movmf(device, map, settings, rows, starts, report, progress);
  return sink.take();
}

MovmfMipmap bake_movmf(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                       FitReport& report, Progress* progress) {
  const PlaneStore normals = planes_of(map);
  std::optional<PlaneStore> colours;
  if (albedo != nullptr) colours = planes_of(*albedo);
  const MapInputs inputs{&normals, FeaturePlanes::of(colours ? &*colours : nullptr, nullptr)};
  return bake_movmf(device, inputs, settings, report, progress);
}

}  // namespace multum
