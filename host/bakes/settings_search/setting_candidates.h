// SPDX-License-Identifier: Apache-2.0
// Lists the settings to try. Bakes to a target (host/bakes/settings_search/chosen_bake.h), the trade-off
// (host/bakes/settings_search/tradeoff_sweep.h) and plans of scenes (host/bakes/scene/map_planner.h) each use a part of
// this list.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bakes/bake/job_parameters.h"

namespace multum {

/// The users of a candidate, as bits.
enum CandidateUser : unsigned {
  kTargetSearch = 1,  // --target-error and --budget-ms
  kQuickSweep = 2,    // multum tradeoff --quick
  kDefaultSweep = 4,  // multum tradeoff
  kFullSweep = 8,     // multum tradeoff --full
  kScenePlan = 16,    // a scene whose error should be that of the default bake
  kSceneTarget = 32,  // a scene with a target error
};

/// The setting that a candidate varies, compared with the default bake.
enum class CandidateAxis { kLobes, kMoments, kHarmonics, kGaussians, kIterations, kHierarchy, kStorage, kFirstLevel };
/// Name of an axis, such as "first level".
const char* candidate_axis_name(CandidateAxis axis);

/// Settings that may be chosen. The cost of a candidate is the number of textures that are read per texel, which
/// determines memory and frame time. If two candidates read the same number of textures, the time of their bakes
/// decides.
struct SettingCandidate {
  ParameterValues values;  // representation, lobes, order, effort and so on; other values are those of the job
  CandidateAxis axis;
  unsigned users;       // bits of CandidateUser
  std::string options;  // the values as options, such as "--ndf vmf --lobes 3"
  int texture_count;    // number of textures with four channels of 16 bits
  int effort;           // rank of the bake time among settings with equal texture counts
  Representation representation() const { return *given_representation(values); }
  int lobe_count() const { return values.integer("lobes").value_or(1); }
  int sh_order() const { return values.integer("sh_order").value_or(0); }
  /// Returns whether JOB's map can be baked with these settings. Refining is possible only for unit normals and binned
  /// normals.
  bool is_for(const BakeJob& job) const;
};

/// Returns the candidates of one user, in the order of display. `only` restricts them to one representation. If `only`
/// is nullopt, all representations are listed.
std::vector<SettingCandidate> setting_candidates(CandidateUser user, std::optional<Representation> only = std::nullopt);

/// Returns the candidates of kTargetSearch with representation `only`, the cheapest first. If `only` is nullopt, lists
/// all except Gaussians. For the same number of lobes, Gaussians cost as much as vMFs, and their error is never lower
/// (docs/evidence/ACCURACY.md).
std::vector<SettingCandidate> target_candidates(std::optional<Representation> only);

/// Number of lobes of the default bake.
int default_lobe_count();

}  // namespace multum
