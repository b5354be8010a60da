// SPDX-License-Identifier: Apache-2.0
// Lists the settings to try. Bakes to a target (host/bakes/settings_search/chosen_bake.h), the trade-off
// (host/bakes/settings_search/tradeoff_sweep.h) and plans of scenes (host/bakes/scene/map_planner.h) each use a part
// of this list.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bakes/bake/job_parameters.h"

namespace multum {

/// Users of a candidate, as bits.
enum CandidateUser : unsigned {
  kTargetSearch = 1,  // --target-error and --budget-ms
  kQuickSweep = 2,    // multum tradeoff --quick
  kDefaultSweep = 4,  // multum tradeoff
  kFullSweep = 8,     // multum tradeoff --full
  kScenePlan = 16,    // a scene whose error should match the default bake
  kSceneTarget = 32,  // a scene with a target error
};

/// The setting that a candidate varies, compared with the default bake.
enum class CandidateAxis { kLobes, kMoments, kHarmonics, kGaussians, kIterations, kHierarchy, kStorage, kFirstLevel };
/// Name of an axis: "first level".
const char* candidate_axis_name(CandidateAxis axis);

/// Settings that may be chosen. The cost of a candidate is the number of textures read per texel, which determines
/// memory and frame time. With equal counts, the time of the bake is the cost.
struct SettingCandidate {
  ParameterValues values;  // representation, lobes, order, effort, ...; the job has the other values
  CandidateAxis axis;
  unsigned users;       // CandidateUser
  std::string options;  // the values as text: "--ndf vmf --lobes 3"
  int texture_count;    // number of textures with four channels of 16 bits
  int effort;           // order of bake times among settings with equal texture counts
  Representation representation() const { return *given_representation(values); }
  int lobe_count() const { return values.integer("lobes").value_or(1); }
  int sh_order() const { return values.integer("sh_order").value_or(0); }
  /// True if JOB's map can be baked with these settings. Refining supports only unit normals and binned normals.
  bool is_for(const BakeJob& job) const;
};

/// Candidates of one user, in the order of display. `only` restricts them to one representation; nullopt means all
/// representations.
std::vector<SettingCandidate> setting_candidates(CandidateUser user, std::optional<Representation> only = std::nullopt);

/// Candidates of kTargetSearch with representation `only`, the cheapest first. nullopt means all except Gaussians: with
/// equal lobe counts, their error is never lower than that of vMFs (docs/evidence/ACCURACY.md), and they cost as much.
std::vector<SettingCandidate> target_candidates(std::optional<Representation> only);

/// Number of lobes of the default bake.
int default_lobe_count();

}  // namespace multum
