// SPDX-License-Identifier: Apache-2.0
// Draws the environment that a camera sees where no object covers it.
#pragma once

#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

/// The scene must have an environment. The result's alpha is 1.
FloatImage environment_background(const RenderScene& scene, int width, int height);

/// Puts the picture in front of the background, weighted by the picture's alpha, which is its coverage. The alpha of
/// the result is 1.
FloatImage before_background(const FloatImage& picture, const FloatImage& background);

}  // namespace multum::gl
