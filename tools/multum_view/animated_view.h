// SPDX-License-Identifier: Apache-2.0
// Draws the frames of `multum-view animate`, between two scenes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/multum_view/view_drawing.h"

namespace multum {

/// What of `from` and `to` changes at `t`, 0..1: linearly, but roughnesses and exponents by equal factors. Both scenes
/// have the same kind of BRDF and as many lights.
gl::RenderScene scene_between(const gl::RenderScene& from, const gl::RenderScene& to, double t);

/// FOLDER/frame_0000.png, ...: the options' picture or sheet of every frame. Returns a row for each, for the report.
nlohmann::json draw_animation(const MapOptions& options, const ViewScenes& scenes, PictureDrawer& drawer);

std::string frame_path(const AnimationOptions& options, int frame);

}  // namespace multum
