// SPDX-License-Identifier: Apache-2.0
// Sums decoded images of a packed field to the texture of a layer, on the GPU. The sum is a weighted sum of gamma-coded
// values, clipped at 0 and converted to radiance. The texture has all mip levels and equals an unpacked texture.
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
  /// Supports textures of up to this size. Throws Error(kEnvironment).
  LayerSum(const GlFunctions& gl, int width_max, int height_max);
  ~LayerSum();
  LayerSum(const LayerSum&) = delete;
  LayerSum& operator=(const LayerSum&) = delete;

  /// Writes all levels of `target`, which is RGBA16F with levels down to 1 x 1. The images must have the size of
  /// `target`.
  void add_up(const std::vector<WeighedTexture>& images, const std::array<float, 3>& offset, const Texture& target);

  /// Returns the memory that a LayerSum for textures of this size needs.
  static std::size_t memory_bytes(int width_max, int height_max);

 private:
  const ShaderProgram& program(const std::vector<std::string>& flags);
  void draw(GLuint texture, int level, int width, int height);

  const GlFunctions& gl_;
  Texture sum_;  // sum of earlier passes, if one pass is not enough
  GLuint framebuffer_ = 0, vertex_array_ = 0;
  std::map<std::vector<std::string>, std::unique_ptr<ShaderProgram>> programs_;
};

}  // namespace multum::gl
