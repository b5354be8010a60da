// SPDX-License-Identifier: Apache-2.0
// Makes the scenes that the renderer draws, with cameras, lights and BRDFs from the options.
#pragma once

#include <optional>
#include <vector>

#include "tools/multum_view/map_options.h"

namespace multum {

struct ViewScenes {
  gl::RenderScene first;
  gl::RenderScene last;            // scene of the last frame; for one picture, the same as the first scene
  std::vector<Brdf> basis;         // several BRDFs, which are blended by the map's weights
  glm::vec3 up{0.0f, 0.0f, 1.0f};  // the up direction of every camera, a unit vector
  bool has_camera = false;
  bool has_last_camera = false;
};

/// Throws Error(kUsage) for cameras, lights and BRDFs that exclude each other.
ViewScenes make_scenes(const PictureOptions& options);
/// Sets the scene of the last frame according to the options.
void change_last_scene(const AnimationOptions& options, ViewScenes& scenes);

/// One picture of a scene, which consists of a camera and the names of its outputs.
struct View {
  OutputOptions output;
  gl::RenderScene scene;
  std::optional<float> distance;  // the factor of --distance
};

/// Returns one view for each --distance, or one view without --distance. `scene` contains the camera of that view.
std::vector<View> views_of(const PictureOptions& options, const gl::RenderScene& scene);

}  // namespace multum
