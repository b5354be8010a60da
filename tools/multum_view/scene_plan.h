// SPDX-License-Identifier: Apache-2.0
// Reads from plan.json, which `multum bake scene.toml` writes, how an object of a scene is drawn.
#pragma once

#include "tools/multum_view/map_options.h"

namespace multum {

/// Sets unset options from the plan's entry for options.object (empty: the plan's only object). Throws Error(kInput) if
/// the file is not a plan, Error(kUsage) if the plan lacks the object.
void apply_scene_plan(MapOptions& options);

}  // namespace multum
