// SPDX-License-Identifier: Apache-2.0
// Plans the shader of an object from the plan of the map that it shows.
#pragma once

#include "host/bakes/scene/scene_plan.h"

namespace multum {

/// `map`: the plan of the map that it shows, complete.
ObjectPlan plan_object(const SceneDescription& scene, const SceneObject& object, const MapPlan& map);

}  // namespace multum
