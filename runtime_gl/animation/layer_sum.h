// SPDX-License-Identifier: Apache-2.0
// Adds up decoded images of a packed field to the texture of a layer, on the GPU: a weighted sum of gamma-coded values,
// clipped at 0, as radiance, with all mip levels, as unpacked textures have them.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "runtime_gl/gl/shader_program.h"
#include "runtime_gl/gl/texture.h"

namespace multum::gl {

struct WeighedTexture {
  const Texture* image;  // RGBA16F, one level
  float weight;
};

class LayerSum {
 public:
  /// For textures of up to so many texels along each side. Throws Error(kEnvironment).
  LayerSum(const GlFunctions& gl, int width_max, int height_max);
  ~LayerSum();
  LayerSum(const LayerSum&) = delete;
  LayerSum& operator=(const LayerSum&) = delete;

  /// Writes all levels of `target`, RGBA16F with levels down to 1 x 1. Images have its size.
  void add_up(const std::vector<WeighedTexture>& images, const std::array<float, 3>& offset, const Texture& target);

  /// What one for textures of this size takes.
  static std::size_t memory_bytes(int width_max, int height_max);

 private:
  const ShaderProgram& program(const std::vector<std::string>& flags);
  void draw(GLuint texture, int level, int width, int height);

  const GlFunctions& gl_;
  Texture sum_;  // of more images than one pass takes
  GLuint framebuffer_ = 0, vertex_array_ = 0;
  std::map<std::vector<std::string>, std::unique_ptr<ShaderProgram>> programs_;
};

}  // namespace multum::gl
