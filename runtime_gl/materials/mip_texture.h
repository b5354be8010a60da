// SPDX-License-Identifier: Apache-2.0
// Makes textures whose mip levels are averaged here: normals, slopes, colours. Textures of a baked file are not made
// here, because their levels are data.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "runtime_gl/gl/texture.h"

namespace multum::gl {

/// A plane of texels, row-major, row 0 first.
struct TexelPlane {
  int width;
  int height;
  std::vector<glm::vec4> texels;
};

/// Uploads an RGBA32F texture with levels 0 to `level_count` - 1, each the box-filtered previous level. Levels do not
/// average the finest texels directly; for sizes that are not powers of two, the weights are the same as in usual mip
/// generators.
Texture upload_mips(const GlFunctions& gl, const char* name, TexelPlane plane, int level_count,
                    const SamplerSettings& sampler);

}  // namespace multum::gl
