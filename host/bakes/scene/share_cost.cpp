// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/share_cost.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/bakes/movmf/mip_schedule.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

// Processor times in nanoseconds per finest texel, fitted by eye. Their sum matches a bake of 16384 x 16384 texels,
// which took 194 s (a later run took 199 s: docs/evidence/BENCHMARKS.md, "Whole bakes of growing maps"). The division
// of the sum among levels, lobes and stages was measured on maps with 1024 and 2048 texels per side
// (tools/lab/share_constants.py prints measured and predicted values). The times were measured on 2 cores of an Intel
// Xeon with AVX-512 and PoCL 3.1, while other programs were running. The additional work of shares was measured on an
// AMD EPYC without AVX-512 (docs/evidence/SHARES.md).
constexpr double kReadCpu = 60.0;          // includes decoding, hashing and detection of the encoding
constexpr double kStoreRows = 8.0;         // writing the map's rows to share 0's file
constexpr double kFitLevelOneCpu = 40.0;   // for level 1
constexpr double kFitLobeOneCpu = 22.0;    // additional time per lobe
constexpr double kFitFineCpu = 15.0;       // each level from 2 to 5
constexpr double kFitLobeFineCpu = 7.5;    // additional time per lobe
constexpr double kFitCoarseCpu = 100.0;    // all coarser levels together
constexpr double kColourFactorCpu = 0.6;   // additional share of the fit per triple of features
constexpr double kBandRows = 12.0;         // copying rows of the map and of lobes to and from shares, per texel of a
                                           // band
constexpr double kMergeMap = 6.0;          // hashing the map, and reading its rows from share 0's file
constexpr double kMergeRows = 12.0;        // reading rows of lobes from all shares
constexpr double kWriteTextureCpu = 30.0;  // per stored texel of a texture
constexpr double kMeasureLambertCpu = 10.0;
constexpr double kMeasureExponentCpu = 30.0;
// Times in seconds that do not depend on the size of the map. They are for starting a process with its programs and
// buffers, for the search for the initial lobes of EM, and for the measurement. They include a minimum time for every
// level.
constexpr double kFixedCpu = 0.15;
constexpr double kFixedStart = 0.45;
constexpr double kFixedWrite = 0.25;
constexpr double kFixedMeasure = 0.09;  // for Lambert, and for each exponent

constexpr int kFinestBinned = 6;
constexpr double kShareCountMax = 1000.0;  // the default limit of tasks of a Slurm array
constexpr double kProcessors = 1.6;        // average number of busy processors, of 2, during a bake of averages

int rgb_planes(const BakeShape& s) { return (s.has_colours ? 1 : 0) + (s.weight_count + 2) / 3; }

double texels_of(const BakeShape& s) { return static_cast<double>(s.width) * s.height; }

// Returns the time of a level in nanoseconds per finest texel.
double level_ns(const BakeShape& s, int level) {
  const auto lobes = static_cast<double>(s.lobe_count);
  const double ns = level == 1               ? kFitLevelOneCpu + kFitLobeOneCpu * lobes
                    : level < kFinestBinned  ? kFitFineCpu + kFitLobeFineCpu * lobes
                    : level == kFinestBinned ? kFitCoarseCpu
                                             : 0.0;
  return ns * (1.0 + kColourFactorCpu * rgb_planes(s));
}

double read_ns(const BakeShape& s) {
  return kReadCpu * (1.0 + (s.has_colours ? 1.0 : 0.0) + (s.weight_count > 0 ? 1.0 : 0.0));
}

double fixed_measure(const BakeShape& s) {
  return kFixedMeasure * (s.exponent_count > 0 ? 1 + s.exponent_count : 0) * (s.has_colours ? 2.0 : 1.0);
}

double write_ns(const BakeShape& s) {
  double stored = 0.0;
  for (int l = s.first_level; l < s.first_level + 12; ++l) stored += std::ldexp(1.0, -2 * l);
  return stored * texture_count(s) * kWriteTextureCpu +
         (kMeasureLambertCpu + kMeasureExponentCpu * s.exponent_count) * (s.has_colours ? 2.0 : 1.0);
}

}  // namespace

double ShareCost::total_seconds() const {
  return std::accumulate(band_seconds.begin(), band_seconds.end(), coarse_seconds + merge_seconds);
}

double ShareCost::band_seconds_max() const {
  return band_seconds.empty() ? 0.0 : *std::max_element(band_seconds.begin(), band_seconds.end());
}

double bake_processor_seconds(const BakeShape& s) {
  const bool is_fitted = holds_lobes(s.representation) && s.lobe_count > 1;
  if (!is_fitted) return kProcessors * bake_cost(s).ms / 1e3;
  double ns = read_ns(s) + write_ns(s);
  for (int level = std::max(1, s.first_level); level <= kFinestBinned; ++level) ns += level_ns(s, level);
  return kFixedCpu + kFixedStart + kFixedWrite + fixed_measure(s) + 1e-9 * ns * texels_of(s);
}

ShareCost share_cost(const BakeShape& s, const MovmfSettings& settings, int count) {
  const MipSchedule schedule = make_mip_schedule(s.width, s.height, settings);
  ShareCost cost;
  cost.coarse_from = plan_shard(schedule, settings, {0, count}).coarse_from;
  double coarse_ns = read_ns(s) + kStoreRows * (1.0 + rgb_planes(s));
  for (int level = cost.coarse_from; level <= std::max(cost.coarse_from, kFinestBinned); ++level)
    coarse_ns += level_ns(s, level);
  cost.coarse_seconds = kFixedCpu + kFixedStart + 1e-9 * coarse_ns * texels_of(s);
  for (int index = 1; index <= count; ++index) {
    const ShardPlan plan = plan_shard(schedule, settings, {index, count});
    const LevelRows read = map_rows(plan, schedule, settings);
    double ns = kBandRows * (1.0 + rgb_planes(s)) * (read.end - read.begin) / s.height;
    for (const LevelSchedule& level : schedule.levels)
      if (const auto fitted = plan.fitted.find(level.level); fitted != plan.fitted.end())
        ns += level_ns(s, level.level) * (fitted->second.end - fitted->second.begin) / level.fit.height;
    cost.band_seconds.push_back(kFixedCpu + 1e-9 * ns * texels_of(s));
  }
  cost.merge_seconds = kFixedCpu + kFixedWrite + fixed_measure(s) +
                       1e-9 * ((kMergeMap + kMergeRows) * (1.0 + rgb_planes(s)) + write_ns(s)) * texels_of(s);
  return cost;
}

int share_count_of(const BakeShape& shape, const MovmfSettings& settings, double share_seconds) {
  const bool is_divided = holds_lobes(shape.representation) && shape.lobe_count > 1 && !settings.refine;
  const double whole = bake_processor_seconds(shape);
  if (!is_divided || share_seconds <= 0.0 || whole <= share_seconds) return 0;
  for (int count = static_cast<int>(std::clamp(std::ceil(whole / share_seconds), 2.0, kShareCountMax)); count >= 2;
       --count) {
    try {
      share_cost(shape, settings, count);
      return count;
    } catch (const Error&) {  // too many bands for this map
    }
  }
  return 0;
}

}  // namespace multum
