// SPDX-License-Identifier: Apache-2.0
// Measures the difference between a scene's bake and the default bake. Small mosaics of the map
// (host/bakes/settings_search/map_mosaic.h) are baked with both settings. The two bakes are compared at all texels of
// the visible levels, at midpoints and half-way between levels, under the scene's lights and for tilts up to the
// scene's limit. The mosaics are independent samples of the map, so the confidence interval follows from their spread.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/scene/scene_plan.h"
#include "host/formats/opencl/device.h"

namespace multum {

/// The relative L1 difference, sum |scene - default bake| / sum default bake, of diffuse light or of highlights,
/// whichever is larger.
struct SceneDifference {
  double error = 0.0;       // mean over levels
  double confidence = 0.0;  // half width of the 95 % interval; 0 if the whole map was compared
  int worst_level = 0;
  double worst_error = 0.0, worst_confidence = 0.0;
  std::string part;  // "lambert", "blinn-phong:100" or "roughness"

  double at_most() const { return worst_error + worst_confidence; }
};

/// Returns a single mosaic if the map is no larger than a mosaic.
std::vector<BakeSource> difference_mosaics(const BakeSource& source);

/// `map.mosaics` must be set. Throws Cancelled.
SceneDifference measure_difference(const SceneDescription& scene, const MapPlan& map, Device& device,
                                   Progress* progress);

}  // namespace multum
