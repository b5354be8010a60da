// SPDX-License-Identifier: Apache-2.0
// Writes a plan as a human-readable table per map and object, and as JSON for programs.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "host/bakes/scene/scene_plan.h"

namespace multum {

/// Lines have at most `width` characters. `width` must be at least 60.
std::string plan_text(const SceneDescription& scene, const ScenePlan& plan, int width);

/// The paths of a scene's files. The files of a map are in `folder` and are named after the map.
struct SceneFiles {
  std::string folder;
  std::string baked(const MapPlan& map) const { return folder + "/" + map.name + ".ndf.exr"; }
  std::string colours(const MapPlan& map) const { return folder + "/" + map.name + ".colours.exr"; }
  std::string plan() const { return folder + "/plan.json"; }
  std::string report() const { return folder + "/report.json"; }
};

/// Formats the decisions with their numbers, and the way in which multum-view draws each object. `multum-view scene
/// plan.json` reads this text. Paths of files are relative to the results folder.
nlohmann::json plan_json(const SceneDescription& scene, const ScenePlan& plan, const SceneFiles& files);

/// Formats values, such as "1.2 s" or "34 ms", "5.3 MiB" or "812 B", and "1.2 %" or "14 %" (for 0.14).
std::string time_text(double ms);
std::string bytes_text(double bytes);
std::string percent_text(double share);
std::string percent_number(double share);  // without the % sign

}  // namespace multum
