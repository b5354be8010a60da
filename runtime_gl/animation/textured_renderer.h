// SPDX-License-Identifier: Apache-2.0
// Draws objects with their inferred textures, which give the radiance. No lighting is computed. Draws supersampling^2
// sub-pixels per pixel and averages them, as in the measurement of the filter matrix.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/gl/shader_program.h"
#include "runtime_gl/gl/texture.h"
#include "runtime_gl/probe/placed_mesh.h"

namespace multum::gl {

struct TexturedObject {
  PlacedMesh placed;
  std::vector<const Texture*> layers;  // textures to add up; if empty, the object is black and hides objects
};

class TexturedRenderer {
 public:
  /// Throws Error(kEnvironment).
  TexturedRenderer(const GlFunctions& gl, int width, int height, int supersampling);
  ~TexturedRenderer();
  TexturedRenderer(const TexturedRenderer&) = delete;
  TexturedRenderer& operator=(const TexturedRenderer&) = delete;

  /// Returns linear radiance times coverage. Alpha is the coverage, 0 to 1.
  FloatImage draw(const std::vector<TexturedObject>& objects);

 private:
  const ShaderProgram& program(std::size_t layer_count);
  void draw_rows(const std::vector<TexturedObject>& objects, int bottom);
  void average_rows(int bottom);

  const GlFunctions& gl_;
  int width_, height_, supersampling_;
  Framebuffer framebuffer_;  // sub-pixels of some rows at a time
  Framebuffer picture_;
  ShaderProgram mean_;
  GLuint vertex_array_ = 0;
  std::map<std::size_t, std::unique_ptr<ShaderProgram>> programs_;  // keyed by number of layers
};

}  // namespace multum::gl
