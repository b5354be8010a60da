// SPDX-License-Identifier: Apache-2.0
// Makes textures whose mip levels are averaged here: normals, slopes, colours. Not the baked file's: its levels are
// data.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "runtime_gl/gl/texture.h"

namespace multum::gl {

/// Row-major, row 0 first.
struct TexelPlane {
  int width;
  int height;
  std::vector<glm::vec4> texels;
};

/// RGBA32F with levels 0 to `level_count` - 1, each the box-filtered level above it. (Of the level above, not of the
/// finest texels: for sizes that are no powers of two the weights are those of any mip generator.)
Texture upload_mips(const GlFunctions& gl, const char* name, TexelPlane plane, int level_count,
                    const SamplerSettings& sampler);

}  // namespace multum::gl
