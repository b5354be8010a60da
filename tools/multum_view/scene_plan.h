// SPDX-License-Identifier: Apache-2.0
// Reads how an object of a scene is drawn out of plan.json, as `multum bake scene.toml` writes it.
#pragma once

#include "tools/multum_view/map_options.h"

namespace multum {

/// Sets what the plan says of options.object (empty: its only one) wherever the options leave it unset. Throws
/// Error(kInput) for a file that is no plan, Error(kUsage) for an object that it does not have.
void apply_scene_plan(MapOptions& options);

}  // namespace multum
