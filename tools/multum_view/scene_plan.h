// SPDX-License-Identifier: Apache-2.0
// Reads the settings for drawing an object of a scene from plan.json, which `multum bake scene.toml` writes.
#pragma once

#include "tools/multum_view/map_options.h"

namespace multum {

/// Sets unset options from the plan's entry for options.object, or for the plan's only object if that is empty. Throws
/// Error(kInput) if the file is not a plan, and Error(kUsage) if the plan does not contain the object.
void apply_scene_plan(MapOptions& options);

}  // namespace multum
