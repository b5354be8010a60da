// SPDX-License-Identifier: Apache-2.0
// Assigns texture units in order. A texture and the sampler that reads it get the same unit.
#pragma once

#include <optional>
#include <vector>

#include "runtime_gl/gl/shader_program.h"
#include "runtime_gl/gl/texture.h"

namespace multum::gl {

class TextureBinder {
 public:
  explicit TextureBinder(const ShaderProgram& shader, int first_unit = 0) : shader_(shader), unit_(first_unit) {}

  void bind(const char* sampler, const Texture& texture);
  void bind(const char* sampler, const std::optional<Texture>& texture);       // does nothing without a texture
  void bind(const char* sampler_array, const std::vector<Texture>& textures);  // one texture per sampler
  int next_unit() const { return unit_; }

 private:
  const ShaderProgram& shader_;
  int unit_;
};

}  // namespace multum::gl
