// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/pyramid/pyramid_renderer.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "host/foundation/base/error.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {

Texture make_pyramid_texture(const GlFunctions& gl, const Pyramid& pyramid, PyramidLookup lookup, float anisotropy) {
  const PyramidHeader& header = pyramid.header;
  const TexelFormat format =
      header.map.encoding == StorageEncoding::kHalf ? TexelFormat::kRgba16f : TexelFormat::kRgba32f;
  Texture texture(gl, std::string("pyramid of ") + pyramid_kind_name(header.kind),
                  {header.map.width, header.map.height, header.level_count(), format},
                  {header.map.wrap_s, header.map.wrap_t, lookup != PyramidLookup::kNearest,
                   lookup == PyramidLookup::kDriver ? anisotropy : 1.0f});
  const auto channels = static_cast<std::size_t>(header.channel_count());
  std::vector<float> rgba;
  for (int l = 0; l < header.level_count(); ++l) {
    const std::vector<float>& values = pyramid.levels[static_cast<std::size_t>(l)].values;
    const std::size_t texels = values.size() / channels;
    rgba.assign(4 * texels, 1.0f);
    for (std::size_t i = 0; i < texels; ++i)
      for (std::size_t c = 0; c < 3; ++c) rgba[4 * i + c] = values[i * channels + (channels == 3 ? c : 0)];
    texture.upload_level(l, rgba.data());
  }
  return texture;
}

const ShaderProgram& PyramidRenderer::program(const std::vector<std::string>& flags) {
  std::string key;
  for (const std::string& flag : flags) key += "|" + flag;
  std::unique_ptr<ShaderProgram>& entry = programs_[key];
  if (entry == nullptr)
    entry = std::make_unique<ShaderProgram>(
        gl_, ShaderSources{"pyramid", flags, {shader_scene_vert}, {shader_common_pyramid_glsl, shader_pyramid_frag}});
  return *entry;
}

FloatImage PyramidRenderer::draw_with(const ShaderProgram& shader, const Mesh& mesh, const PyramidScene& scene) {
  const glm::mat4 matrix = view_projection(scene.camera, framebuffer_.width(), framebuffer_.height(), scene.shift);
  shader.set_mat4("u_view_projection", glm::value_ptr(matrix));
  shader.set("u_uv_scale", scene.uv_scale);
  shader.set("u_level_bias", scene.level_bias);
  shader.set_vec3("u_frame", glm::value_ptr(scene.frame[0]), 3);
  framebuffer_.bind();
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  framebuffer_.clear_colour();
  framebuffer_.clear_depth();
  shader.use();
  mesh.draw();
  check_gl(gl_, "drawing a pyramid");
  return framebuffer_.read();
}

FloatImage PyramidRenderer::draw(const Mesh& mesh, const Texture& map, PyramidLookup lookup, bool by_normal,
                                 const PyramidScene& scene) {
  std::vector<std::string> flags;
  if (by_normal) flags.push_back("MULTUM_BY_NORMAL");
  if (lookup == PyramidLookup::kLevel) flags.push_back("MULTUM_LEVEL");
  if (lookup == PyramidLookup::kNearest || lookup == PyramidLookup::kBilinear) flags.push_back("MULTUM_FINEST");
  const ShaderProgram& shader = program(flags);
  shader.set("u_map", 0);
  map.bind(0);
  return draw_with(shader, mesh, scene);
}

FloatImage PyramidRenderer::draw_levels(const Mesh& mesh, const Texture& map, bool by_normal,
                                        const PyramidScene& scene) {
  std::vector<std::string> flags = {"MULTUM_SHOW_LEVEL"};
  if (by_normal) flags.push_back("MULTUM_BY_NORMAL");
  const ShaderProgram& shader = program(flags);
  shader.set("u_map", 0);
  map.bind(0);
  return draw_with(shader, mesh, scene);
}

FloatImage PyramidRenderer::draw_phong(const Mesh& mesh, const PhongLights& lights, const PyramidScene& scene) {
  MULTUM_CHECK(lights.lights.size() <= kLightCountMax);
  const ShaderProgram& shader = program({"MULTUM_PHONG"});
  std::array<glm::vec3, kLightCountMax> directions{}, irradiances{};
  for (std::size_t i = 0; i < lights.lights.size(); ++i) {
    directions[i] = glm::normalize(lights.lights[i].direction);
    irradiances[i] = lights.lights[i].irradiance;
  }
  shader.set("u_light_count", static_cast<int>(lights.lights.size()));
  shader.set_vec3("u_light_directions", glm::value_ptr(directions[0]), kLightCountMax);
  shader.set_vec3("u_light_irradiances", glm::value_ptr(irradiances[0]), kLightCountMax);
  shader.set_vec3("u_diffuse", glm::value_ptr(lights.diffuse), 1);
  shader.set_vec3("u_specular", glm::value_ptr(lights.specular), 1);
  shader.set("u_exponent", lights.exponent);
  return draw_with(shader, mesh, scene);
}

double flicker(const std::vector<FloatImage>& pictures, const std::vector<FloatImage>& references) {
  MULTUM_CHECK(!pictures.empty() && pictures.size() == references.size());
  const auto count = static_cast<double>(pictures.size());
  double variance = 0.0, light = 0.0;
  std::size_t values = 0;
  for (std::size_t i = 0; i < references[0].rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    double sum = 0.0, square = 0.0;
    for (std::size_t k = 0; k < pictures.size(); ++k) {
      const double off = static_cast<double>(pictures[k].rgba[i]) - static_cast<double>(references[k].rgba[i]);
      sum += off;
      square += off * off;
      light += static_cast<double>(references[k].rgba[i]) / count;
    }
    variance += std::max(square / count - sum * sum / (count * count), 0.0);
    ++values;
  }
  return light > 0.0 ? std::sqrt(variance / static_cast<double>(values)) / (light / static_cast<double>(values)) : 0.0;
}

}  // namespace multum::gl
