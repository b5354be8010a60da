// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/setting_candidates.h"

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>

namespace multum {
namespace {

using Axis = CandidateAxis;
using Given = std::initializer_list<std::pair<const char*, ParameterValue>>;

constexpr unsigned kDefaultAndFull = kDefaultSweep | kFullSweep;
constexpr unsigned kEverySweep = kQuickSweep | kDefaultAndFull;
constexpr unsigned kEveryScene = kScenePlan | kSceneTarget;

// The order of candidates with equal texture counts, by the time of their bakes (docs/evidence/ACCURACY.md).
enum Effort { kAveraged, kQuickFit, kDefaultFit, kRefinedFit, kLongFit };

Effort effort_of(const ParameterValues& values, Representation representation) {
  if (!holds_lobes(representation)) return kAveraged;
  if (values.flag("reference")) return kLongFit;
  if (values.flag("refine")) return kRefinedFit;
  return values.flag("no_start_search") && values.integer("passes") == 1 ? kQuickFit : kDefaultFit;
}

TexelCounts counts_of(const ParameterValues& values) {
  return {values.integer("lobes").value_or(1), values.integer("sh_order").value_or(0)};
}

bool is_one_of(int value, std::initializer_list<int> list) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

class CandidateList {
 public:
  std::vector<SettingCandidate> make() && {
    add_lobes();
    add_averages();
    add_gaussians();
    add_efforts(default_lobes_, kEverySweep);
    add_change(Axis::kStorage, kEverySweep, {{"data_format", "half"}});
    add_first_levels();
    add_changes_of_fit();
    add_storages();
    for (int lobes = counts_.fewest; lobes <= counts_.most; ++lobes)
      if (lobes != default_lobes_) add_efforts(lobes, kFullSweep);
    return std::move(all_);
  }

 private:
  void add(Axis axis, unsigned users, const ParameterValues& values) {
    const Representation representation = given_representation(values).value();
    all_.push_back({values, axis, users, options_text(values), texture_count(representation, counts_of(values), 0),
                    effort_of(values, representation)});
  }
  // Adds vMF lobes for which some settings are changed.
  void add_fit(Axis axis, unsigned users, int lobes, Given changes) {
    ParameterValues values = bake_values({{"ndf", "vmf"}, {"lobes", std::int64_t{lobes}}});
    for (const auto& [name, value] : changes) values.set(name, value);
    add(axis, users, values);
  }
  void add_change(Axis axis, unsigned users, Given changes) { add_fit(axis, users, default_lobes_, changes); }

  void add_lobes() {
    for (int lobes = counts_.fewest; lobes <= counts_.most; ++lobes)
      add_fit(Axis::kLobes,
              kTargetSearch | kDefaultAndFull | (is_one_of(lobes, {1, 2, 4, 6}) ? kQuickSweep : 0u) | kSceneTarget |
                  (lobes <= default_lobes_ ? kScenePlan : 0u),
              lobes, {});
  }

  void add_averages() {
    add(Axis::kMoments, kTargetSearch | kEverySweep | kEveryScene, bake_values({{"ndf", "moments"}}));
    // The orders that are worth a trial. Each order has about 1.5 times as many coefficients as the previous one. The
    // default sweep ends at order 12, which is between two of them.
    for (const int order : {2, 3, 4, 6, 8, 10, 12, 13, 16, 20}) {
      const unsigned users =
          (order != 12 ? kTargetSearch | kFullSweep : 0u) | (is_one_of(order, {2, 4, 6, 8, 12}) ? kDefaultSweep : 0u) |
          (is_one_of(order, {4, 8}) ? kQuickSweep : 0u) | (is_one_of(order, {2, 4}) ? kEveryScene : 0u);
      add(Axis::kHarmonics, users, bake_values({{"ndf", "sh"}, {"sh_order", std::int64_t{order}}}));
    }
  }

  void add_gaussians() {
    for (int lobes = counts_.fewest; lobes <= counts_.most; ++lobes) {
      const unsigned users = kTargetSearch | kFullSweep | (is_one_of(lobes, {1, 2, 4, 6}) ? kDefaultSweep : 0u) |
                             (lobes == default_lobes_ ? kQuickSweep : 0u) | kSceneTarget |
                             (lobes <= default_lobes_ ? kScenePlan : 0u);
      add(Axis::kGaussians, users, bake_values({{"ndf", "gmm"}, {"lobes", std::int64_t{lobes}}}));
    }
  }

  // Adds the quick, the refined and the long fit. For the default lobe count, the long fit is already among the other
  // changes of the fit. A target search tries the long fit only for the largest lobe count. With fewer lobes, adding a
  // lobe reduces the error more and takes less time.
  void add_efforts(int lobes, unsigned sweeps) {
    add_fit(Axis::kIterations, kTargetSearch | sweeps, lobes, {{"passes", std::int64_t{1}}, {"no_start_search", true}});
    if (lobes > 1)  // one lobe is an average and is not fitted
      add_fit(Axis::kIterations, kTargetSearch | (sweeps & kDefaultAndFull), lobes, {{"refine", true}});
    if (lobes != default_lobes_)
      add_fit(Axis::kIterations, sweeps | (lobes == counts_.most ? kTargetSearch : 0u), lobes, {{"reference", true}});
  }

  // Without level 0, lobes need a quarter of the memory, so more lobes fit.
  void add_first_levels() {
    for (int lobes = counts_.fewest; lobes <= counts_.most; ++lobes)
      add_fit(Axis::kFirstLevel,
              kFullSweep | (is_one_of(lobes, {1, 2, 3, 4, 6, 8}) ? kDefaultSweep : 0u) |
                  (is_one_of(lobes, {2, 4}) ? kQuickSweep : 0u),
              lobes, {{"first_level", std::int64_t{1}}});
  }

  void add_changes_of_fit() {
    for (const int iterations : {3, 6})
      add_change(Axis::kIterations, kDefaultAndFull, {{"iterations", std::int64_t{iterations}}});
    for (const int passes : {1, 3}) add_change(Axis::kIterations, kDefaultAndFull, {{"passes", std::int64_t{passes}}});
    add_change(Axis::kIterations, kDefaultAndFull, {{"no_start_search", true}});
    add_change(Axis::kIterations, kDefaultAndFull, {{"reference", true}});
    add_change(Axis::kIterations, kDefaultAndFull, {{"coarse_normals", "all"}});
    add_change(Axis::kHierarchy, kDefaultAndFull, {{"unaligned", true}});
    for (const double alignment : {0.0, 1.0}) add_change(Axis::kHierarchy, kDefaultAndFull, {{"align", alignment}});
    add_change(Axis::kHierarchy, kDefaultAndFull, {{"order", "scanline"}});
  }

  void add_storages() {
    add_change(Axis::kStorage, kDefaultAndFull, {{"data_format", "float"}});
    add_change(Axis::kFirstLevel, kDefaultAndFull, {{"first_level", std::int64_t{2}}});
    for (const char* compression : {"none", "piz"})
      add_change(Axis::kStorage, kDefaultAndFull, {{"compression", compression}});
  }

  const LobeCounts counts_ = lobe_counts();
  const int default_lobes_ = default_lobe_count();
  std::vector<SettingCandidate> all_;
};

}  // namespace

const char* candidate_axis_name(CandidateAxis axis) {
  static constexpr const char* kNames[] = {"lobes",      "moments",   "harmonics", "Gaussians",
                                           "iterations", "hierarchy", "storage",   "first level"};
  return kNames[static_cast<std::size_t>(axis)];
}

bool SettingCandidate::is_for(const BakeJob& job) const {
  return !values.flag("refine") || (job.roughness.empty() && job.fitting.coarse_normals != CoarseNormals::kAll);
}

std::vector<SettingCandidate> setting_candidates(CandidateUser user, std::optional<Representation> only) {
  std::vector<SettingCandidate> candidates = CandidateList().make();
  std::erase_if(candidates, [&](const SettingCandidate& one) {
    return (one.users & user) == 0 || (only && one.representation() != *only);
  });
  return candidates;
}

std::vector<SettingCandidate> target_candidates(std::optional<Representation> only) {
  std::vector<SettingCandidate> candidates = setting_candidates(kTargetSearch, only);
  std::stable_sort(candidates.begin(), candidates.end(), [](const SettingCandidate& a, const SettingCandidate& b) {
    return std::pair(a.texture_count, a.effort) < std::pair(b.texture_count, b.effort);
  });
  return candidates;
}

int default_lobe_count() { return std::stoi(bake_parameters().at("lobes").default_text); }

}  // namespace multum
