// SPDX-License-Identifier: Apache-2.0
// Bakes what a plan asks for into a folder: a file a map, NAME.ndf.exr, its mean colours in NAME.colours.exr where the
// plan has them, plan.json, and report.json. Each file appears whole or not at all; what is there already from the same
// sources with the same settings stays, so that a killed run goes on where it was.
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
  bool is_by_trials = false;  // lobes for the scene's target error, and not as planned:
  std::string options;        // what was chosen; empty where it was there already
  std::string earlier;        // of a map that was left as it is, or that a share baked, its row in the report (JSON)
  bool has_colours = false;   // in a file of their own:
  MipReport colours;
  double seconds = 0.0;
  std::uint64_t file_bytes = 0;
  // Measured after the bakes, of maps that are baked otherwise than by default and are no single texel.
  std::optional<SceneDifference> difference;
};

struct SceneReport {
  ScenePlan plan;  // with what trials chose
  std::vector<SceneMapReport> maps;
  double seconds = 0.0;          // of the bakes; ScenePlan::plan_seconds comes before
  double compare_seconds = 0.0;  // of measuring differences from the default bake
  // Of all maps together, comparisons not among them.
  std::map<std::string, std::uint64_t> launches;  // by kernel
  std::map<std::string, int> builds;              // by kernels/FILE.cl

  nlohmann::json to_json() const;
  nlohmann::json map_rows() const;  // its "maps"
  /// Some lines for a terminal.
  std::string to_text() const;
};

using SceneMapDone = std::function<void(const MapPlan&, const SceneMapReport&)>;

/// The folder must be there. Throws Error for the first map that fails, Cancelled; maps before it stay.
SceneReport bake_scene(const SceneDescription& scene, const ScenePlan& plan, const SceneFiles& files, Device& device,
                       const SceneMapDone& done, Progress* progress);

// What bake_scene() is made of, for shares of it (host/bakes/scene/scene_share.h).

/// Rows of maps in a report, as JSON, by name.
using SceneMapRows = std::map<std::string, std::string>;

/// Of the report of an earlier bake; empty where there is none.
SceneMapRows earlier_rows(const std::string& path);

/// Bakes the plan's maps; neither plan nor report is written.
SceneReport bake_scene_maps(const SceneDescription& scene, const ScenePlan& plan, const SceneFiles& files,
                            const SceneMapRows& earlier, Device& device, const SceneMapDone& done, Progress* progress);

/// Measures differences from the default bake, of maps that were baked otherwise. Throws Cancelled.
void compare_scene_maps(const SceneDescription& scene, const ScenePlan& plan, SceneReport& report, Device& device,
                        Progress* progress);

/// Puts what trials chose into the report's plan, by the baked files, and writes that where they chose anything.
void write_settled_plan(const SceneDescription& scene, const SceneFiles& files, SceneReport& report);

}  // namespace multum
