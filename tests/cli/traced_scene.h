// SPDX-License-Identifier: Apache-2.0
// A folder of ray-traced pictures made here: a patterned ground, a glossy board that stands on it, seen from two views
// under two lights. Every radiance is a formula of the point, the light and the eye, so that what texture inference
// ought to find is known.
#pragma once

#include <functional>
#include <string>

namespace multum::testing {

struct TracedScene {
  int width = 96, height = 72;
  int views = 2, lights = 2;
  bool has_hidden_object = false;  // a third one, below the ground
  double camera_shift = 0.0;       // sideways: where scene.json says that cameras are, not where they were
  bool has_depth_holes = false;    // NaN in the depth of some pixels
  bool has_object_index = false;   // id_vVV_pPP.png beside the geometry passes
  bool has_bad_pixels = false;     // NaN and infinity in some radiances of the diffuse pass
};

/// scene.json, geometry.obj, rad_vVV_pPP.exr, geom_vVV.exr.
void write_traced_folder(const std::string& folder, const TracedScene& scene);

}  // namespace multum::testing
