// SPDX-License-Identifier: Apache-2.0
// Makes the scenes that the renderer draws from the options: cameras, lights, BRDFs.
#pragma once

#include <optional>
#include <vector>

#include "tools/multum_view/map_options.h"

namespace multum {

struct ViewScenes {
  gl::RenderScene first;
  gl::RenderScene last;            // the last frame's scene; without frames, the same as the first
  std::vector<Brdf> basis;         // several: blended by the map's weights
  glm::vec3 up{0.0f, 0.0f, 1.0f};  // unit; the camera's up direction, also when the camera frames the mesh
  bool has_camera = false;
  bool has_last_camera = false;
};

/// Throws Error(kUsage) for cameras, lights and BRDFs that exclude each other.
ViewScenes make_scenes(const PictureOptions& options);
/// Changes the last frame's scene as the options say.
void change_last_scene(const AnimationOptions& options, ViewScenes& scenes);

/// One picture of a scene: its camera, and the names of its outputs.
struct View {
  OutputOptions output;
  gl::RenderScene scene;
  std::optional<float> distance;  // the factor of --distance
};

/// Returns one view for each --distance, or one view; `scene` has its camera.
std::vector<View> views_of(const PictureOptions& options, const gl::RenderScene& scene);

}  // namespace multum
