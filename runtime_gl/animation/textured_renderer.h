// SPDX-License-Identifier: Apache-2.0
// Draws objects with the textures that were inferred for them: radiance is looked up and nothing is lit. Drawn with
// supersampling^2 sub-pixels a pixel and averaged, as the filter matrix was measured.
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
  std::vector<const Texture*> layers;  // added up; none: black, and hides what is behind
};

class TexturedRenderer {
 public:
  /// Throws Error(kEnvironment).
  TexturedRenderer(const GlFunctions& gl, int width, int height, int supersampling);
  ~TexturedRenderer();
  TexturedRenderer(const TexturedRenderer&) = delete;
  TexturedRenderer& operator=(const TexturedRenderer&) = delete;

  /// Linear radiance times coverage; alpha = coverage, 0..1.
  FloatImage draw(const std::vector<TexturedObject>& objects);

 private:
  const ShaderProgram& program(std::size_t layer_count);
  void draw_rows(const std::vector<TexturedObject>& objects, int bottom);
  void average_rows(int bottom);

  const GlFunctions& gl_;
  int width_, height_, supersampling_;
  Framebuffer framebuffer_;  // sub-pixels, of some rows at a time
  Framebuffer picture_;
  ShaderProgram mean_;
  GLuint vertex_array_ = 0;
  std::map<std::size_t, std::unique_ptr<ShaderProgram>> programs_;  // by number of layers
};

}  // namespace multum::gl
