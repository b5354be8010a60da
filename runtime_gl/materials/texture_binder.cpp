// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/texture_binder.h"

namespace multum::gl {

void TextureBinder::bind(const char* sampler, const Texture& texture) {
  shader_.set(sampler, unit_);
  texture.bind(unit_++);
}

void TextureBinder::bind(const char* sampler, const std::optional<Texture>& texture) {
  if (texture.has_value()) bind(sampler, *texture);
}

void TextureBinder::bind(const char* sampler_array, const std::vector<Texture>& textures) {
  if (textures.empty()) return;
  shader_.set_units(sampler_array, unit_, static_cast<int>(textures.size()));
  for (const Texture& texture : textures) texture.bind(unit_++);
}

}  // namespace multum::gl
