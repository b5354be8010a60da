// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/scene_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "host/bakes/scene/effect_rows.h"
#include "host/bakes/scene/map_planner.h"
#include "host/bakes/scene/object_plan.h"
#include "host/bakes/scene/scene_difference.h"
#include "host/formats/image/files/environment_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/leading_number.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

// If there is a target and several lobes are needed, trials choose the number of vMF lobes, up to the maximum
// (host/bakes/scene/scene_bake.cpp).
std::optional<TrialRange> trials_of(const SceneBudget& budget, const BakeCandidate& chosen) {
  if (!budget.target_error || !holds_lobes(chosen.shape.representation) || chosen.shape.lobe_count < 2)
    return std::nullopt;
  const auto with_lobes = [&](int lobes) {
    BakeCandidate candidate = chosen;
    candidate.shape.representation = default_representation();
    candidate.shape.encoding = representation_info(default_representation()).encodings.front();
    candidate.shape.lobe_count = lobes;
    candidate.name = fmt::format("vmf, {} lobe{}", lobes, lobes == 1 ? "" : "s");
    candidate.cost = bake_cost(candidate.shape);
    return candidate;
  };
  return TrialRange{with_lobes(lobe_counts().fewest), with_lobes(lobe_counts().most)};
}

// Fills in the job of a plan.
void fill_job(const MapNeeds& needs, const SceneBudget& budget, MapPlan& plan) {
  const BakeShape& s = plan.chosen.shape;
  BakeJob& job = plan.job;
  job.representation = s.representation;
  job.sh_order = s.sh_order;
  job.fitting.lobe_count = s.lobe_count;
  job.fitting.first_level = s.first_level;
  job.encoding = s.encoding;
  plan.mean_colours = s.mean_colours;
  if (s.mean_colours) plan.colour_file = job.albedo;
  if (!s.has_colours) job.albedo.clear();
  if (!needs.weighted) job.weights.clear();
  if (plan.source && job.albedo.empty()) plan.source->albedo.reset();
  if (plan.source && job.weights.empty()) plan.source->weights.reset();
  job.measured_exponents = needs.exponents();
  for (double& exponent : job.measured_exponents) exponent = leading_number(fmt::format("{:.4g}", exponent)).value();
  job.stored_only = s.first_level > 0;
  const bool as_default = !budget.target_error && plan.chosen.name == plan.default_bake.name &&
                          s.encoding == plan.default_bake.shape.encoding;
  if (plan.is_constant) job.measure = false;  // the spread of normals is known to be 0
  plan.stated_difference = as_default && !plan.is_constant
                               ? 0.0
                               : plan.chosen.error.worst() + plan.default_bake.error.worst() + budget.estimate_margin;
  // Settings from trials meet the target, but their error may be higher than that of the default bake.
  if (plan.trials)
    plan.stated_difference = std::max(plan.chosen.error.worst(), *budget.target_error) +
                             plan.default_bake.error.worst() + budget.estimate_margin;
}

// Reduces the cost until it meets the scene's budgets. Repeatedly takes the step that increases the error least.
void hold_to_budgets(const SceneBudget& budget, std::vector<MapPlan>& maps) {
  for (const auto& [limit, what, value] :
       {std::tuple{budget.bytes, "bytes", &BakeCost::bytes}, std::tuple{budget.bake_ms, "bake_ms", &BakeCost::ms}}) {
    if (!limit) continue;
    for (;;) {
      double total = 0.0;
      for (const MapPlan& map : maps) total += map.chosen.cost.*value;
      if (total <= *limit) break;
      MapPlan* cheapest = nullptr;
      const BakeCandidate* step = nullptr;
      for (MapPlan& map : maps)
        for (const BakeCandidate& c : map.candidates)
          if (c.cost.*value < map.chosen.cost.*value && (step == nullptr || c.error.worst() < step->error.worst())) {
            cheapest = &map;
            step = &c;
          }
      if (step == nullptr)
        throw Error(ErrorCode::kVerification,
                    fmt::format("no settings meet the budget {} = {:g}; the lowest possible value is {:.6g}", what,
                                *limit, total));
      cheapest->chosen = *step;
    }
  }
}

}  // namespace

ScenePlan plan_scene(const SceneDescription& scene, const PlanSettings& settings, Progress* progress) {
  const Stopwatch stopwatch;
  ScenePlan plan;
  if (!scene.environment.empty()) check_environment_map(scene.environment);
  std::vector<std::unique_ptr<MapPlanner>> planners;
  std::uint64_t kept = 0;
  for (std::size_t m = 0; m < scene.maps.size(); ++m) {
    progress_stage(progress, "plan");
    BakeJob job = scene.maps[m].job;
    job.threads = settings.threads;
    if (job.scratch_folder.empty()) job.scratch_folder = std::filesystem::temp_directory_path().string();
    BakeReport read;  // not used, because the bake also reports warnings about the maps
    auto source = std::make_shared<BakeSource>(read_source(job, MapReadings::kMany, read, progress));
    planners.push_back(std::make_unique<MapPlanner>(scene, m, source, settings));
    plan.maps.push_back(planners.back()->plan());
    MapPlan& map = plan.maps.back();
    if (settings.for_bake && !map.is_constant)
      map.mosaics = std::make_shared<std::vector<BakeSource>>(difference_mosaics(*source));
    const std::uint64_t bytes =
        static_cast<std::uint64_t>(map.width) * static_cast<std::uint64_t>(map.height) * 12 * (source->albedo ? 2 : 1);
    if (kept + bytes <= settings.kept_bytes_max) {
      map.source = source;
      kept += bytes;
    }
  }
  hold_to_budgets(scene.budget, plan.maps);
  for (std::size_t m = 0; m < plan.maps.size(); ++m) {
    MapPlan& map = plan.maps[m];
    map.trials = trials_of(scene.budget, map.chosen);
    add_effect_rows(scene, *planners[m], map);
    fill_job(planners[m]->needs(), scene.budget, map);
    plan.cost += map.chosen.cost;
    plan.cost_min += map.trials ? map.trials->fewest.cost : map.chosen.cost;
    plan.cost_max += map.trials ? map.trials->most.cost : map.chosen.cost;
    plan.default_cost += map.default_bake.cost;
  }
  for (const SceneObject& object : scene.objects)
    plan.objects.push_back(plan_object(scene, object, plan.maps[object.map]));
  plan.plan_seconds = stopwatch.seconds();
  return plan;
}

}  // namespace multum
