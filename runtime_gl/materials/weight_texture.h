// SPDX-License-Identifier: Apache-2.0
// Makes a texture of the weights of basis BRDFs, with one channel per BRDF, for baked files of any representation.
#pragma once

#include <vector>

#include "runtime_gl/gl/texture.h"

namespace multum::gl {

/// `levels` has the weights of each level, with `weight_count` weights per texel. Uses RGBA16F, or RGBA32F for files
/// that hold floats.
Texture upload_weights(const GlFunctions& gl, const char* name, const TextureShape& shape,
                       const SamplerSettings& sampler, int weight_count,
                       const std::vector<const std::vector<float>*>& levels);

/// Uploads the weights of a mipmap that holds one set of weights per texel.
template <typename Mipmap>
Texture upload_weights(const GlFunctions& gl, const TextureShape& shape, const SamplerSettings& sampler,
                       const Mipmap& mipmap) {
  std::vector<const std::vector<float>*> levels;
  for (int l = mipmap.header.first_level; l < mipmap.header.level_count(); ++l)
    levels.push_back(&mipmap.levels[static_cast<std::size_t>(l)].weights);
  return upload_weights(gl, "weights", shape, sampler, mipmap.header.weight_count, levels);
}

}  // namespace multum::gl
