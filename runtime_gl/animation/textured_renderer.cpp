// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/animation/textured_renderer.h"

#include <algorithm>
#include <string>

#include <glm/gtc/type_ptr.hpp>

#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
TexturedRenderer::TexturedRenderer(const GlFunctions& gl, int width, int height, int supersampling)
    : gl_(gl),
      width_(width),
      height_(height),
      supersampling_(supersampling),
      framebuffer_(gl, width * supersampling,
                   band_row_count(width * supersampling, height * supersampling, supersampling)),
      picture_(gl, width, height),
      mean_(gl, {"mean of sub-pixels",
                 {"MULTUM_SIDE " + std::to_string(supersampling)},
                 {shader_full_screen_vert},
                 {shader_sub_pixel_mean_frag}}) {
  gl.CreateVertexArrays(1, &vertex_array_);
}

TexturedRenderer::~TexturedRenderer() { gl_.DeleteVertexArrays(1, &vertex_array_); }

const ShaderProgram& TexturedRenderer::program(std::size_t layer_count) {
  std::unique_ptr<ShaderProgram>& entry = programs_[layer_count];
  if (entry == nullptr)
    entry = std::make_unique<ShaderProgram>(gl_, ShaderSources{"textured",
                                                               {"MULTUM_LAYER_COUNT " + std::to_string(layer_count)},
                                                               {shader_textured_vert},
                                                               {shader_textured_frag}});
  return *entry;
}

/// Draws rows of sub-pixels to framebuffer_, from row `bottom` on, counted from below.
void TexturedRenderer::draw_rows(const std::vector<TexturedObject>& objects, int bottom) {
  framebuffer_.bind_rows(bottom, height_ * supersampling_);
  framebuffer_.clear_colour();
  framebuffer_.clear_depth();
  gl_.Enable(GL_DEPTH_TEST);
  for (const TexturedObject& object : objects) {
    const ShaderProgram& shader = program(object.layers.size());
    shader.use();
    shader.set_mat4("u_object_to_clip", glm::value_ptr(object.placed.object_to_clip));
    shader.set_units("u_layers", 0, static_cast<int>(object.layers.size()));
    for (std::size_t i = 0; i < object.layers.size(); ++i) object.layers[i]->bind(static_cast<int>(i));
    object.placed.mesh->draw();
  }
  gl_.Disable(GL_DEPTH_TEST);
  check_gl(gl_, "drawing textured objects");
}

/// Averages the sub-pixels of framebuffer_ into the picture.
void TexturedRenderer::average_rows(int bottom) {
  const int first = bottom / supersampling_, rows = std::min(framebuffer_.height() / supersampling_, height_ - first);
  picture_.bind();
  gl_.Viewport(0, first, width_, rows);
  mean_.use();
  mean_.set("u_first_row", first);
  mean_.set("u_sub_pixels", 0);
  framebuffer_.bind_colour(0);
  gl_.BindVertexArray(vertex_array_);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  check_gl(gl_, "averaging sub-pixels");
}

FloatImage TexturedRenderer::draw(const std::vector<TexturedObject>& objects) {
  for (int bottom = 0; bottom < height_ * supersampling_; bottom += framebuffer_.height()) {
    draw_rows(objects, bottom);
    average_rows(bottom);
  }
  return picture_.read();
}

}  // namespace multum::gl
