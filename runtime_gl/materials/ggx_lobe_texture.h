// SPDX-License-Identifier: Apache-2.0
// Makes a texture of the table in host/formats/brdf/ggx_lobe.h, for brdf/ggx_lobe.glsl.
#pragma once

#include "runtime_gl/gl/texture.h"

namespace multum::gl {

Texture make_ggx_lobe_texture(const GlFunctions& gl);

}  // namespace multum::gl
