// SPDX-License-Identifier: Apache-2.0
// Draws the environment that a camera sees where nothing stands before it.
#pragma once

#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

/// Of a scene that has an environment. Alpha is 1.
FloatImage environment_background(const RenderScene& scene, int width, int height);

/// The picture before the background, which shows as far as alpha, the picture's coverage, leaves it. Alpha is then 1.
FloatImage before_background(const FloatImage& picture, const FloatImage& background);

}  // namespace multum::gl
