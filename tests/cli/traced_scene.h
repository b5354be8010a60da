// SPDX-License-Identifier: Apache-2.0
// Makes a folder of ray-traced pictures: a patterned ground and a glossy upright board, seen from two views under two
// lights. A formula gives the radiance for each point, light and eye, so the expected result of texture inference is
// known.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/cli/program.h"

namespace multum::testing {

struct TracedScene {
  int width = 96, height = 72;
  int views = 2, lights = 2;
  bool has_hidden_object = false;  // adds a third object, below the ground
  double camera_shift = 0.0;       // how far the cameras in scene.json are shifted sideways from their true positions
  bool has_depth_holes = false;    // the depth of some pixels is NaN
  bool has_object_index = false;   // writes id_vVV_pPP.png next to the geometry passes
  bool has_bad_pixels = false;     // some radiances of the diffuse pass are NaN or infinite
};

/// Writes scene.json, geometry.obj, rad_vVV_pPP.exr and geom_vVV.exr.
void write_traced_folder(const std::string& folder, const TracedScene& scene);

/// Base class of tests with a traced scene: renders/, animation.toml, and out/ with its textures.
class TracedSceneTest : public CliTest {
 protected:
  void write_scene(const TracedScene& scene);
  ProgramResult infer(std::vector<std::string> more = {"--no-comparison"}) const;
  /// Writes the folder of pictures and infers the textures, with the fastest settings.
  void infer_scene(const TracedScene& scene);
};

}  // namespace multum::testing
