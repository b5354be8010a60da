// SPDX-License-Identifier: Apache-2.0
// Decides which effects of each map a scene needs, and how each map is baked. Chooses the cheapest candidate whose
// estimated error exceeds that of the default bake by at most a margin (docs/contributing/ALGORITHMS.md, "Plans of
// scenes" lists the rules).
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/bake/bake_source.h"
#include "host/bakes/pyramid/mip_bake.h"
#include "host/bakes/scene/bake_cost.h"
#include "host/bakes/scene/scene_file.h"

namespace multum {

/// One of the settings that a row of the table lists, and its estimate.
struct PlannedItem {
  std::string name;   // "2 lobes"
  std::string value;  // "0.21/45 %"
};

/// A row of the plan's table.
struct PlannedEffect {
  std::string effect;
  bool needed = false;
  std::string why;                     // the reason, with the measured number
  bool has_cost = false;               // true if the effect has a cost in the bake; other effects are only shader code
  BakeCost cost;                       // the cost that the effect adds, or saves if it is not needed
  std::vector<PlannedItem> list = {};  // candidates that were tried, sorted by cost; may be empty
};

/// The estimated relative L1 errors of diffuse light and of highlights.
struct PartErrors {
  double diffuse = 0.0, specular = 0.0;
  double worst() const { return std::max(diffuse, specular); }
  bool within(const PartErrors& limit) const { return diffuse <= limit.diffuse && specular <= limit.specular; }
};

/// A way to bake a map, and its estimated error and cost.
struct BakeCandidate {
  std::string name;  // "vmf, 2 lobes", "moments"
  BakeShape shape;
  bool lobe_colours = false;  // false for one mean colour per texel
  PartErrors error;
  BakeCost cost;
};

/// The fewest and the most lobes that trials may choose.
struct TrialRange {
  BakeCandidate fewest, most;
};

struct MapPlan {
  std::string name;
  BakeJob job;                // has no output path
  bool mean_colours = false;  // true if mean colours of colour_file are baked to a separate file
  std::string colour_file;    // the albedo, if mean_colours is set
  int width = 0, height = 0, level_count = 0;
  int first_seen = 0, last_seen = 0;      // levels that are seen
  double z_min = 0.0;                     // the smallest z of the map's normals
  bool is_diffuse = false;                // true if at least one material is diffuse
  bool is_constant = false;               // true if all normals are nearly equal, so that the coarsest level suffices
  BakeCandidate chosen, default_bake;     // the chosen bake, and the default bake for comparison
  std::optional<TrialRange> trials;       // set if trials of the bake choose the settings; `chosen` is then an estimate
  bool default_error_is_bound = false;    // true if default_bake's error is only an upper bound
  PartErrors limit;                       // errors that candidates must not exceed
  std::vector<BakeCandidate> candidates;  // sorted by textures, then time
  double stated_difference = 0.0;         // estimated relative L1 difference from pictures of the default bake
  std::vector<PlannedEffect> effects;
  std::shared_ptr<BakeSource> source;  // the job's inputs, if they are kept in memory
  // Small samples of the map for host/bakes/scene/scene_difference.h. The pointer is null if no bake follows or if one
  // texel represents the map.
  std::shared_ptr<std::vector<BakeSource>> mosaics;
};

struct ObjectPlan {
  std::string name;
  std::size_t map = 0;
  int first_level = 0, last_level = 0;  // levels that are seen
  std::vector<PlannedEffect> effects;   // effects of its shader
  bool environment_by_harmonics = false;
  std::optional<glm::dvec3> fixed_fresnel;  // constant that replaces the Fresnel term F
  double stated_difference = 0.0;           // the sum of the stated differences of the object's map and of its shader
};

struct ScenePlan {
  std::vector<MapPlan> maps;
  std::vector<ObjectPlan> objects;
  BakeCost cost, default_cost;
  BakeCost cost_min, cost_max;  // range of `cost` that trials allow
  double plan_seconds = 0.0;
};

struct PlanSettings {
  int threads = 1;
  bool for_bake = true;  // true if a bake follows
  // Maps up to this total size stay in memory for the bake. All other maps are read again.
  std::uint64_t kept_bytes_max = std::uint64_t{4} << 30;
};

/// Reads every map once. Throws Error(kInput) for unusable maps. Throws Error(kVerification), with the best candidate
/// in its message, if no candidate reaches the scene's target error or its budgets.
ScenePlan plan_scene(const SceneDescription& scene, const PlanSettings& settings, Progress* progress);

}  // namespace multum
