// SPDX-License-Identifier: Apache-2.0
// A folder of ray-traced pictures made here: a patterned ground, a glossy board that stands on it, seen from two views
// under two lights. Every radiance is a formula of the point, the light and the eye, so that what texture inference
// ought to find is known.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/cli/program.h"

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

/// Tests of what becomes of one: renders/, animation.toml and out/, its textures.
class TracedSceneTest : public CliTest {
 protected:
  void write_scene(const TracedScene& scene);
  ProgramResult infer(std::vector<std::string> more = {"--no-comparison"}) const;
  /// Both, as fast as they go.
  void infer_scene(const TracedScene& scene);
};

}  // namespace multum::testing
