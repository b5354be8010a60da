// SPDX-License-Identifier: Apache-2.0
// Draws the frames of `multum-view animate`, between two scenes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/multum_view/view_drawing.h"

namespace multum {

/// Interpolates between `from` and `to`, where `t` is in 0..1. Roughnesses and exponents are interpolated
/// geometrically, and other values linearly. Both scenes must have the same kind of BRDF and the same number of lights.
gl::RenderScene scene_between(const gl::RenderScene& from, const gl::RenderScene& to, double t);

/// Writes FOLDER/frame_0000.png and so on, with a picture or sheet for every frame. Returns one report row per frame.
nlohmann::json draw_animation(const MapOptions& options, const ViewScenes& scenes, PictureDrawer& drawer);

std::string frame_path(const AnimationOptions& options, int frame);

}  // namespace multum
