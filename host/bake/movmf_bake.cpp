// SPDX-License-Identifier: Apache-2.0
#include "host/bake/movmf_bake.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "host/bake/mip_schedule.h"
#include "host/bake/movmf_fit.h"
#include "host/bake/movmf_start.h"
#include "host/base/error.h"

namespace multum {
namespace {

// The pyramid of a small likeness of the map from each candidate, and its error at texel centres and between: a start
// is as good as the levels that grow from it, and neither its likelihood nor its own error tells (on the four-quarter
// map with 6 lobes the best of them came 14th by error). 4096 normals take some 50 ms a candidate.
double rehearse(Device& device, const NormalMap& likeness, const MovmfSettings& settings, const MovmfFitPlan& plan) {
  constexpr int kSideMax = 16;  // of the levels that are compared: finer ones of the likeness hold too few normals
  BakeReport ignored;
  const MovmfMipmap mipmap = fit_movmf(device, likeness, nullptr, settings, plan, ignored, nullptr);
  AccuracySettings accuracy;
  accuracy.samples_per_level = 0;
  accuracy.threads = 1;  // too small to share
  accuracy.directions = {{{0.0, 0.0, 1.0}}, spread_half_vectors(64)};
  const auto too_fine = [&](int level) {
    const MovmfLevel& size = mipmap.levels[static_cast<std::size_t>(level)];
    return size.width > kSideMax || size.height > kSideMax;
  };
  while (too_fine(accuracy.first_level)) ++accuracy.first_level;
  double error = 0.0;  // the product of the errors, so that no BRDF or level outweighs the others
  for (const AccuracyRow& row : measure_accuracy(device, mipmap, likeness, accuracy, nullptr))
    if (row.brdf != "lambert") error += std::log(row.error + 0.005);
  return error;
}

std::vector<MultumVmfLobe> choose_start(Device& device, const NormalMap& map, const MovmfSettings& settings,
                                        BakeReport& report) {
  constexpr int kLikenessSide = 64;
  const auto started = std::chrono::steady_clock::now();
  const std::uint64_t launches_before = device.launch_total();
  const StartSearch search{settings.lobe_count, settings.kappa_cap, 1, 2};
  std::vector<std::vector<MultumVmfLobe>> candidates = start_candidates(map, search);
  report.starts_rehearsed = 0;
  std::size_t best = 0;
  // Levels that do not grow from the coarsest cannot tell starts apart.
  if (settings.rehearse_start && settings.aligned_start && candidates.size() > 1) {
    MovmfSettings whole = settings;
    whole.first_level = 0;  // of the likeness, which has fewer levels than the map
    const NormalMap likeness = sample_likeness(map, kLikenessSide, search.seed);
    MovmfFitPlan plan;
    plan.weighted = make_mip_schedule(map.width, map.height, settings).weighted;  // no second set of programs
    double least = HUGE_VAL;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      plan.top_start = candidates[c];
      const double error = rehearse(device, likeness, whole, plan);
      ++report.starts_rehearsed;
      if (error >= least) continue;
      least = error;
      best = c;
    }
  }
  report.start_launches = device.launch_total() - launches_before;
  report.start_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return candidates[best];
}

}  // namespace

void validate(const MovmfSettings& settings, int map_width, int map_height) {
  validate(settings);
  if (map_width > 32768 || map_height > 32768)
    throw Error(ErrorCode::kInput,
                fmt::format("found a map of {} x {}, expected at most 32768 texels a side", map_width, map_height));
  const int level_max = mip_level_count(map_width, map_height) - 1;
  if (settings.first_level > level_max)
    throw Error(ErrorCode::kUsage, fmt::format("--first-level is {}, expected 0 to {}, the levels of a map of {} x {}",
                                               settings.first_level, level_max, map_width, map_height));
}

MovmfMipmap bake_movmf(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                       BakeReport& report, Progress* progress) {
  validate(settings, map.width, map.height);
  MULTUM_CHECK(albedo == nullptr || (albedo->width == map.width && albedo->height == map.height));
  progress_stage(progress, "choose a start");
  const MovmfFitPlan plan{choose_start(device, map, settings, report), false};
  MovmfMipmap mipmap = fit_movmf(device, map, albedo, settings, plan, report, progress);
  report.device = device.info().name;
  return mipmap;
}

std::uint64_t movmf_bake_units(int width, int height, int first_level) {
  return static_cast<std::uint64_t>(mip_level_count(width, height) - first_level) * static_cast<std::uint64_t>(width) *
         static_cast<std::uint64_t>(height);
}

}  // namespace multum
