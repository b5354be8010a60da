// SPDX-License-Identifier: Apache-2.0
// Decides which effects a scene needs of its maps, from the scene and from the maps themselves, and with that how each
// map is baked: the cheapest of all candidates whose estimated error stays within a margin of the default bake's
// (docs/contributing/ALGORITHMS.md, "Plans of scenes" has the rules).
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

/// Of a row, one of the settings that were estimated.
struct PlannedItem {
  std::string name;   // "2 lobes"
  std::string value;  // "0.21/45 %"
};

/// A row of the plan's table.
struct PlannedEffect {
  std::string effect;
  bool needed = false;
  std::string why;                     // with the number that was measured
  bool has_cost = false;               // of the bake; others are code in a shader alone
  BakeCost cost;                       // that it takes, or saves where it is not needed
  std::vector<PlannedItem> list = {};  // what was tried, in the order of what it costs; may be empty
};

/// Estimated, relative L1, of diffuse light and of highlights.
struct PartErrors {
  double diffuse = 0.0, specular = 0.0;
  double worst() const { return std::max(diffuse, specular); }
  bool within(const PartErrors& limit) const { return diffuse <= limit.diffuse && specular <= limit.specular; }
};

/// A way to bake a map, and what is expected of it.
struct BakeCandidate {
  std::string name;  // "vmf, 2 lobes", "moments"
  BakeShape shape;
  bool lobe_colours = false;  // not one mean colour a texel
  PartErrors error;
  BakeCost cost;
};

/// The fewest and the most lobes that trials may choose.
struct TrialRange {
  BakeCandidate fewest, most;
};

struct MapPlan {
  std::string name;
  BakeJob job;                // all but where the output goes
  bool mean_colours = false;  // of colour_file, in a file of their own
  std::string colour_file;    // the albedo, where mean_colours
  int width = 0, height = 0, level_count = 0;
  int first_seen = 0, last_seen = 0;      // levels
  double z_min = 0.0;                     // of the map's normals
  bool is_diffuse = false;                // some material is
  bool is_constant = false;               // every normal stands for all: the coarsest level is enough
  BakeCandidate chosen, default_bake;     // the default bake
  std::optional<TrialRange> trials;       // set: the bake's trials are to choose, and `chosen` is an estimate
  bool default_error_is_bound = false;    // of the default bake it is known that its error is no more
  PartErrors limit;                       // that candidates were held to
  std::vector<BakeCandidate> candidates;  // by textures, then time
  double stated_difference = 0.0;         // from pictures of the default bake, relative L1, by the estimates
  std::vector<PlannedEffect> effects;
  std::shared_ptr<BakeSource> source;  // what the job reads, where it is kept
  // Small samples of the map, for host/bakes/scene/scene_difference.h; null: no bake comes after, or one texel stands
  // for all.
  std::shared_ptr<std::vector<BakeSource>> mosaics;
};

struct ObjectPlan {
  std::string name;
  std::size_t map = 0;
  int first_level = 0, last_level = 0;  // seen
  std::vector<PlannedEffect> effects;   // of its shader
  bool environment_by_harmonics = false;
  std::optional<glm::dvec3> fixed_fresnel;  // a number does for F
  double stated_difference = 0.0;           // its map's, and what the shader adds
};

struct ScenePlan {
  std::vector<MapPlan> maps;
  std::vector<ObjectPlan> objects;
  BakeCost cost, default_cost;
  BakeCost cost_min, cost_max;  // of `cost`, what trials may make of it
  double plan_seconds = 0.0;
};

struct PlanSettings {
  int threads = 1;
  bool for_bake = true;  // a bake comes after
  // Maps stay read for the bake up to so many bytes together; beyond, they are read again.
  std::uint64_t kept_bytes_max = std::uint64_t{4} << 30;
};

/// Reads every map once. Throws Error(kInput) for maps that cannot be used, Error(kVerification) where no candidate
/// reaches the scene's target error or its budgets, saying what the nearest does.
ScenePlan plan_scene(const SceneDescription& scene, const PlanSettings& settings, Progress* progress);

}  // namespace multum
