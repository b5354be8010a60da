// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/animation/textured_renderer.h"

#include <algorithm>
#include <array>

#include <glm/gtc/type_ptr.hpp>

#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

// Adds the sub-pixels of a band to the pixels that they belong to. `top`: first sub-pixel row of the band.
void add_band(const FloatImage& band, int top, int supersampling, FloatImage& picture) {
  const float share = 1.0f / static_cast<float>(supersampling * supersampling);
  for (int y = 0, i = 0; y < band.height; ++y)
    for (int x = 0; x < band.width; ++x, ++i) {
      const int pixel = (top + y) / supersampling * picture.width + x / supersampling;
      for (int c = 0; c < 4; ++c)
        picture.rgba[static_cast<std::size_t>(4 * pixel + c)] += share * band.rgba[static_cast<std::size_t>(4 * i + c)];
    }
}

}  // namespace

TexturedRenderer::TexturedRenderer(const GlFunctions& gl, int width, int height, int supersampling)
    : gl_(gl),
      width_(width),
      height_(height),
      supersampling_(supersampling),
      framebuffer_(gl, width * supersampling,
                   band_row_count(width * supersampling, height * supersampling, supersampling)) {}

const ShaderProgram& TexturedRenderer::program(std::size_t layer_count) {
  std::unique_ptr<ShaderProgram>& entry = programs_[layer_count];
  if (entry == nullptr)
    entry = std::make_unique<ShaderProgram>(gl_, ShaderSources{"textured",
                                                               {"MULTUM_LAYER_COUNT " + std::to_string(layer_count)},
                                                               {shader_textured_vert},
                                                               {shader_textured_frag}});
  return *entry;
}

FloatImage TexturedRenderer::draw(const std::vector<TexturedObject>& objects) {
  FloatImage picture{width_, height_,
                     std::vector<float>(4u * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_))};
  const int sub_height = height_ * supersampling_, rows_a_band = framebuffer_.height();
  for (int bottom = 0; bottom < sub_height; bottom += rows_a_band) {
    framebuffer_.bind_rows(bottom, sub_height);
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
    check_gl(gl_, "drawing textured objects");
    const int hidden = std::max(0, bottom + rows_a_band - sub_height);
    const int top = std::max(0, sub_height - bottom - rows_a_band);
    add_band(framebuffer_.read(0, {0, hidden, framebuffer_.width(), rows_a_band - hidden}), top, supersampling_,
             picture);
  }
  return picture;
}

}  // namespace multum::gl
