// SPDX-License-Identifier: Apache-2.0
// Divides the bake of a scene among processes that share the output folder: maps are dealt out in turn. A share bakes
// its maps and notes them in a record (host/foundation/base/share_record.h); a merge checks the records of all shares,
// and the baked files by their hashes, and writes plan.json and report.json. A budget of all maps together has every
// share plan all of them; otherwise a share reads its own alone.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/scene/scene_bake.h"

namespace multum {

struct SceneRun {
  std::string scene_file;
  SceneDescription scene;  // of that file
  SceneFiles files;
  PlanSettings planning;
  bool force = false;  // bake what is there, too
};

struct SceneShareReport {
  bool was_there = false;  // whole, of the same inputs and settings: nothing was done
  int maps = 0;            // of the share
};

/// Share `index` of `count`, from 1. Throws as plan_scene() and bake_scene() do.
SceneShareReport bake_scene_share(const SceneRun& run, int index, int count, Device& device, const SceneMapDone& done,
                                  Progress* progress);

/// Throws Error(kEnvironment) that names every share whose record or files are missing, damaged or of something else,
/// with the option that makes it again; and as plan_scene() does.
SceneReport merge_scene(const SceneRun& run, int count, Progress* progress);

}  // namespace multum
