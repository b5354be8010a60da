// SPDX-License-Identifier: Apache-2.0
// Bakes a plan into a folder. For each map, writes NAME.ndf.exr and, if planned, mean colours to NAME.colours.exr. Also
// writes plan.json and report.json. Each file appears when it is complete, or not at all. Existing files from the same
// sources and settings are kept, so that a killed run can continue.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/bake/bake_report.h"
#include "host/bakes/scene/plan_text.h"
#include "host/bakes/scene/scene_difference.h"
#include "host/bakes/scene/scene_plan.h"

namespace multum {

struct SceneMapReport {
  std::string name;
  BakeReport bake;
  bool is_by_trials = false;  // true if trials choose the lobes for the scene's target error
  std::string options;        // chosen options; empty if the file already existed
  std::string earlier;        // JSON row of the report, for a map that was unchanged or baked by a share
  bool has_colours = false;   // colours in a separate file:
  MipReport colours;
  double seconds = 0.0;
  std::uint64_t file_bytes = 0;
  // The difference that is measured after the bakes. It is set for maps that are larger than one texel and that are not
  // baked with default settings.
  std::optional<SceneDifference> difference;
};

struct SceneReport {
  ScenePlan plan;  // including the choices of trials
  std::vector<SceneMapReport> maps;
  double seconds = 0.0;          // time of the bakes; ScenePlan::plan_seconds is separate
  double compare_seconds = 0.0;  // time to measure differences from the default bake
  // The counts over all maps, without comparisons.
  std::map<std::string, std::uint64_t> launches;  // number of launches per kernel
  std::map<std::string, int> builds;              // number of builds per kernels/FILE.cl

  nlohmann::json to_json() const;
  nlohmann::json map_rows() const;  // the "maps" of the JSON report
  /// Formats a few lines for a terminal.
  std::string to_text() const;
};

using SceneMapDone = std::function<void(const MapPlan&, const SceneMapReport&)>;

/// The folder must exist. Throws Error for the first map that fails, and Cancelled. Finished maps remain.
SceneReport bake_scene(const SceneDescription& scene, const ScenePlan& plan, const SceneFiles& files, Device& device,
                       const SceneMapDone& done, Progress* progress);

// The steps of bake_scene(), for shares of a scene (host/bakes/scene/scene_share.h).

/// The rows of maps in a report as JSON, by the name of the map.
using SceneMapRows = std::map<std::string, std::string>;

/// Returns the rows of an earlier bake's report. The result is empty if there is no such report.
SceneMapRows earlier_rows(const std::string& path);

/// Bakes the plan's maps. Writes neither the plan nor the report.
SceneReport bake_scene_maps(const SceneDescription& scene, const ScenePlan& plan, const SceneFiles& files,
                            const SceneMapRows& earlier, Device& device, const SceneMapDone& done, Progress* progress);

/// Measures differences from the default bake for maps that are baked with other settings. Throws Cancelled.
void compare_scene_maps(const SceneDescription& scene, const ScenePlan& plan, SceneReport& report, Device& device,
                        Progress* progress);

/// Copies the settings that trials have chosen from the baked files to the report's plan. If there are any such
/// settings, also writes the plan.
void write_settled_plan(const SceneDescription& scene, const SceneFiles& files, SceneReport& report);

}  // namespace multum
