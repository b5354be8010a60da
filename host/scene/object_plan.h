// SPDX-License-Identifier: Apache-2.0
// What an object's shader holds.
#pragma once

#include "host/scene/scene_plan.h"

namespace multum {

/// `map`: the plan of the map that it shows, complete.
ObjectPlan plan_object(const SceneDescription& scene, const SceneObject& object, const MapPlan& map);

}  // namespace multum
