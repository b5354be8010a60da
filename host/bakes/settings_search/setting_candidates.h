// SPDX-License-Identifier: Apache-2.0
// Lists the settings that are tried: one list for bakes to a target (host/bakes/settings_search/chosen_bake.h), the
// trade-off (host/bakes/settings_search/tradeoff_sweep.h) and plans of scenes (host/bakes/scene/map_planner.h), of
// which each takes its part.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bakes/bake/job_parameters.h"

namespace multum {

/// Who tries a candidate: bits.
enum CandidateUser : unsigned {
  kTargetSearch = 1,  // --target-error and --budget-ms
  kQuickSweep = 2,    // multum tradeoff --quick
  kDefaultSweep = 4,  // multum tradeoff
  kFullSweep = 8,     // multum tradeoff --full
  kScenePlan = 16,    // a scene whose bakes are to be as good as the default's
  kSceneTarget = 32,  // a scene with a target error
};

/// Which setting a candidate varies, against the default bake.
enum class CandidateAxis { kLobes, kMoments, kHarmonics, kGaussians, kIterations, kHierarchy, kStorage, kFirstLevel };
/// "first level".
const char* candidate_axis_name(CandidateAxis axis);

/// Settings that may be chosen. What they cost, the most important first: textures that are read for a texel, which is
/// memory and frame time; of as many, the bake's time.
struct SettingCandidate {
  ParameterValues values;  // representation, lobes, order, effort, ...; all else is the job's
  CandidateAxis axis;
  unsigned users;       // CandidateUser
  std::string options;  // the values for people: "--ndf vmf --lobes 3"
  int texture_count;    // of four channels of 16 bits
  int effort;           // of as many textures: less bakes faster
  Representation representation() const { return *given_representation(values); }
  int lobe_count() const { return values.integer("lobes").value_or(1); }
  int sh_order() const { return values.integer("sh_order").value_or(0); }
  /// Can JOB's map be baked so? Refining knows unit normals alone, and binned ones.
  bool is_for(const BakeJob& job) const;
};

/// Those of one user, in the order in which they are shown. `only`: of this representation; unset: of all.
std::vector<SettingCandidate> setting_candidates(CandidateUser user, std::optional<Representation> only = std::nullopt);

/// Those of kTargetSearch that `only` allows, cheapest first. Unset: all but Gaussians, which of as many lobes are
/// never nearer than vMFs (docs/evidence/ACCURACY.md), and cost as much.
std::vector<SettingCandidate> target_candidates(std::optional<Representation> only);

/// The lobes of the default bake.
int default_lobe_count();

}  // namespace multum
