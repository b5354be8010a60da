// SPDX-License-Identifier: Apache-2.0
// Makes textures of normals, slopes and colours, and averages their mip levels. Textures of a baked file are not made
// here, because their levels are data.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "runtime_gl/gl/texture.h"

namespace multum::gl {

/// A plane of texels in row-major order, starting with row 0.
struct TexelPlane {
  int width;
  int height;
  std::vector<glm::vec4> texels;
};

/// Uploads an RGBA32F texture with levels 0 to `level_count` - 1. Each level is made from the previous level by a box
/// filter, as is usual for mip generators. For sizes that are not powers of two, the result differs from an average of
/// the finest texels.
Texture upload_mips(const GlFunctions& gl, const char* name, TexelPlane plane, int level_count,
                    const SamplerSettings& sampler);

}  // namespace multum::gl
