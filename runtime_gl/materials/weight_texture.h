// SPDX-License-Identifier: Apache-2.0
// Weights of basis BRDFs as a texture, a channel each, whatever else a baked file's texels are.
#pragma once

#include <vector>

#include "runtime_gl/gl/texture.h"

namespace multum::gl {

/// `levels`: of each the weights, `weight_count` a texel; RGBA16F, or RGBA32F of files that hold floats.
Texture upload_weights(const GlFunctions& gl, const char* name, const TextureShape& shape,
                       const SamplerSettings& sampler, int weight_count,
                       const std::vector<const std::vector<float>*>& levels);

}  // namespace multum::gl
