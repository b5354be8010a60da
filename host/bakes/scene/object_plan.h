// SPDX-License-Identifier: Apache-2.0
// Plans the shader of an object, based on the plan of its map.
#pragma once

#include "host/bakes/scene/scene_plan.h"

namespace multum {

/// `map` is the complete plan of the object's map.
ObjectPlan plan_object(const SceneDescription& scene, const SceneObject& object, const MapPlan& map);

}  // namespace multum
