// SPDX-License-Identifier: Apache-2.0
// Makes the rows of a map's table in a plan. Each row states an effect, whether the map's bake needs it, and the number
// that justifies the decision.
#pragma once

#include "host/bakes/scene/map_planner.h"

namespace multum {

/// Appends the rows to plan.effects, for the bake plan.chosen.
void add_effect_rows(const SceneDescription& scene, MapPlanner& planner, MapPlan& plan);

}  // namespace multum
