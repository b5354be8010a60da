// SPDX-License-Identifier: Apache-2.0
// Reads the settings for drawing an object of a scene from plan.json, which `multum bake scene.toml` writes.
#pragma once

#include "tools/multum_view/map_options.h"

namespace multum {

/// Sets options that are still unset from the plan's entry for options.object. If options.object is empty, uses the
/// only object of the plan. Throws Error(kInput) if the file is not a plan, and Error(kUsage) if the plan does not
/// contain the object.
void apply_scene_plan(MapOptions& options);

}  // namespace multum
