// SPDX-License-Identifier: Apache-2.0
// Divides the bake of a scene among processes that use the same output folder. Maps are assigned to shares in turn. A
// share bakes its maps and lists them in a record (host/foundation/base/share_record.h). A merge checks the records of
// all shares and the hashes of the baked files, and writes plan.json and report.json. If the scene has a budget for all
// maps together, every share plans all maps. Otherwise a share reads only its own maps.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/scene/scene_bake.h"

namespace multum {

struct SceneRun {
  std::string scene_file;
  SceneDescription scene;  // read from that file
  SceneFiles files;
  PlanSettings planning;
  bool force = false;  // true to also bake maps whose files exist
};

struct SceneShareReport {
  bool was_there = false;  // true if nothing was done because the share had already been baked with the same inputs and
                           // settings
  int maps = 0;            // number of maps in the share
};

/// Bakes share `index` of `count`. Shares are counted from 1. Throws the same errors as plan_scene() and bake_scene().
SceneShareReport bake_scene_share(const SceneRun& run, int index, int count, Device& device, const SceneMapDone& done,
                                  Progress* progress);

/// If records or files of shares are missing, damaged or from another bake, throws Error(kEnvironment) that names these
/// shares and the option that bakes a share again. Also throws the errors of plan_scene().
SceneReport merge_scene(const SceneRun& run, int count, Progress* progress);

}  // namespace multum
