// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/weight_texture.h"

#include <glm/vec4.hpp>

namespace multum::gl {

Texture upload_weights(const GlFunctions& gl, const char* name, const TextureShape& shape,
                       const SamplerSettings& sampler, int weight_count,
                       const std::vector<const std::vector<float>*>& levels) {
  TextureShape weights_shape = shape;
  weights_shape.format = shape.format == TexelFormat::kRgba32f ? TexelFormat::kRgba32f : TexelFormat::kRgba16f;
  Texture texture(gl, name, weights_shape, sampler);
  const auto count = static_cast<std::size_t>(weight_count);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    std::vector<glm::vec4> texels(levels[l]->size() / count, glm::vec4(0.0f));
    for (std::size_t i = 0; i < texels.size(); ++i)
      for (std::size_t k = 0; k < count; ++k) texels[i][static_cast<glm::length_t>(k)] = (*levels[l])[i * count + k];
    texture.upload_level(static_cast<int>(l), &texels[0].x);
  }
  return texture;
}

}  // namespace multum::gl
