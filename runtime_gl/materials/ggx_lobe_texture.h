// SPDX-License-Identifier: Apache-2.0
// The table of host/formats/brdf/ggx_lobe.h as a texture for brdf/ggx_lobe.glsl.
#pragma once

#include "runtime_gl/gl/texture.h"

namespace multum::gl {

Texture make_ggx_lobe_texture(const GlFunctions& gl);

}  // namespace multum::gl
