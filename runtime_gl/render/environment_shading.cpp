// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/environment_shading.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec4.hpp>

#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/vmf_terms.h"
#include "host/formats/light/reflection_table.h"
#include "host/foundation/base/error.h"
#include "runtime_gl/materials/texture_binder.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

// A grid over the picture. The light L' (light/environment_sh.glsl) is computed for the view directions of the grid's
// nodes.
constexpr int kGridColumns = 9, kGridRows = 7;
constexpr SamplerSettings kClamped{WrapMode::kClamp, WrapMode::kClamp, true, 1.0f};

void set_smooth(const ShaderProgram& shader, const SmoothEnvironment& smooth) {
  const glm::vec3 mean(smooth.mean[0], smooth.mean[1], smooth.mean[2]);
  std::array<glm::vec3, 3> linear;
  std::array<glm::vec3, 9> quadratic;
  for (std::size_t c = 0; c < 3; ++c) {
    linear[c] = glm::vec3(smooth.linear[c]);
    for (int row = 0; row < 3; ++row)
      quadratic[3 * c + static_cast<std::size_t>(row)] = glm::vec3(smooth.quadratic[c][row]);
  }
  shader.set_vec3("u_smooth_mean", glm::value_ptr(mean), 1);
  shader.set_vec3("u_smooth_linear", glm::value_ptr(linear[0]), 3);
  shader.set_vec3("u_smooth_quadratic", glm::value_ptr(quadratic[0]), 9);
}

}  // namespace

std::array<glm::vec3, 3> environment_axes(const RenderScene& scene) {
  const glm::vec3& up = scene.environment_up;
  const glm::vec3 ahead = std::abs(up.y) < 0.9f ? glm::vec3(0.0f, 1.0f, 0.0f) : glm::vec3(0.0f, 0.0f, -1.0f);
  const glm::vec3 z = -glm::normalize(ahead - up * glm::dot(up, ahead)), x = glm::cross(up, z);
  const float angle = glm::radians(scene.environment_turn);
  const float cosine = std::cos(angle), sine = std::sin(angle);
  return {cosine * x - sine * z, up, sine * x + cosine * z};
}

int environment_sample_count(int sample_count) {
  constexpr int kLeast = 8, kOfPixel = 256;
  if (sample_count == 0) return kLeast;
  return std::clamp((kOfPixel + sample_count - 1) / sample_count, kLeast, kEnvironmentSampleCount);
}

ShaderParts environment_shader_parts(const RenderScene& scene, bool samples_light) {
  if (scene.environment == nullptr) return {};
  ShaderParts parts{{"MULTUM_ENVIRONMENT"}, {}};
  if (samples_light) {
    parts.flags.push_back("MULTUM_ENVIRONMENT_SAMPLES " + std::to_string(kEnvironmentSampleCount));
    parts.texts = {shader_light_environment_frame_glsl, shader_light_environment_samples_glsl};
    return parts;
  }
  parts.texts = {shader_common_vmf_zonal_glsl, shader_light_environment_frame_glsl, shader_light_environment_glsl};
  if (scene.brdf.kind == BrdfKind::kLambert) return parts;
  parts.flags.push_back("MULTUM_ENVIRONMENT_TERMS " +
                        std::to_string(is_vmf_sum(scene.brdf) ? scene.brdf.term_count : 1));
  const bool is_harmonic = scene.environment_mode == EnvironmentMode::kHarmonics;
  parts.flags.push_back(is_harmonic ? "MULTUM_ENVIRONMENT_SH" : "MULTUM_ENVIRONMENT_LEVELS");
  parts.texts.push_back(is_harmonic ? shader_light_environment_sh_glsl : shader_light_environment_levels_glsl);
  return parts;
}

void EnvironmentShading::set_map(const RenderScene& scene) {
  if (light_ == scene.environment) return;
  light_ = scene.environment;
  const std::vector<EnvironmentMap>& levels = light_->levels.levels;
  const int level_count = static_cast<int>(levels.size());
  map_.reset();
  map_.emplace(*gl_, "the environment",
               TextureShape{levels[0].width, levels[0].height, level_count, TexelFormat::kRgba32f},
               SamplerSettings{WrapMode::kPeriodic, WrapMode::kClamp, true, 1.0f});
  for (int l = 0; l < level_count; ++l) {
    std::vector<glm::vec4> texels;
    for (const glm::vec3& texel : levels[static_cast<std::size_t>(l)].texels) texels.emplace_back(texel, 1.0f);
    map_->upload_level(l, &texels[0].x);
  }
}

EnvironmentShading::Tables EnvironmentShading::make_tables(const Brdf& brdf) const {
  Tables made;
  for (const VmfTerm& term : vmf_terms(brdf)) made.term_spreads.push_back(static_cast<float>(term.spread));
  // Lambert has no terms, and its Fresnel part is not used.
  const auto tables = reflection_tables(brdf);
  std::vector<glm::vec4> texels;
  for (const auto& table : tables)
    for (const ReflectionEntry& e : table) texels.emplace_back(glm::vec3(e.weight), static_cast<float>(e.plain));
  if (tables.empty()) return made;
  for (const ReflectionEntry& e : tables[0]) texels.emplace_back(glm::vec3(static_cast<float>(e.fresnel)), 0.0f);
  const int planes = static_cast<int>(tables.size()) + 1;
  made.texture.emplace(*gl_, "reflection tables",
                       TextureShape{kReflectionCosineCount, planes * kReflectionSpreadCount, 1, TexelFormat::kRgba32f},
                       kClamped);
  made.texture->upload_level(0, &texels[0].x);
  return made;
}

void EnvironmentShading::set_half_vector_light(const RenderScene& scene, glm::ivec2 viewport) {
  const glm::mat4 inverse = glm::inverse(view_projection(scene.camera, viewport.x, viewport.y, glm::vec2(0.0f)));
  const std::array<glm::vec3, 3> axes = environment_axes(scene);
  constexpr int kNodes = kGridColumns * kGridRows;
  std::vector<glm::vec4> texels(static_cast<std::size_t>(kNodes * (kHalfVectorOrder + 1) * (kHalfVectorOrder + 1)));
  for (int y = 0; y < kGridRows; ++y)
    for (int x = 0; x < kGridColumns; ++x) {
      const glm::vec4 far = inverse * glm::vec4(2.0f * static_cast<float>(x) / (kGridColumns - 1) - 1.0f,
                                                2.0f * static_cast<float>(y) / (kGridRows - 1) - 1.0f, 1.0f, 1.0f);
      const glm::vec3 v = glm::normalize(scene.camera.eye - glm::vec3(far) / far.w);
      const glm::dvec3 view =
          glm::normalize(glm::dvec3(glm::dot(axes[0], v), glm::dot(axes[1], v), glm::dot(axes[2], v)));
      const std::vector<glm::dvec3> light = half_vector_light(scene.environment->small, view);
      for (std::size_t i = 0; i < light.size(); ++i)
        texels[i * kNodes + static_cast<std::size_t>(y * kGridColumns + x)] = glm::vec4(glm::vec3(light[i]), 1.0f);
    }
  half_vector_light_.reset();
  half_vector_light_.emplace(
      *gl_, "light over half vectors",
      TextureShape{kGridColumns, static_cast<int>(texels.size()) / kGridColumns, 1, TexelFormat::kRgba32f}, kClamped);
  half_vector_light_->upload_level(0, &texels[0].x);
}

void EnvironmentShading::set_sample(const ShaderProgram& shader, const RenderScene& scene, int sample,
                                    int count) const {
  shader.set("u_sample", sample);
  if (scene.environment == nullptr) return;
  std::vector<glm::vec3> directions;
  for (int i = 0; i < count; ++i)
    directions.emplace_back(scene.environment->sampler.direction(static_cast<unsigned>(sample * count + i)));
  shader.set_vec3("u_light_samples", glm::value_ptr(directions[0]), count);
  shader.set("u_light_sample_count", count);
}

void EnvironmentShading::set(const ShaderProgram& shader, const RenderScene& scene, bool samples_light,
                             glm::ivec2 viewport, int unit) {
  if (scene.environment == nullptr) return;
  const std::clock_t start = std::clock();
  set_parts(shader, scene, samples_light, viewport, unit);
  processor_seconds_ += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

void EnvironmentShading::set_parts(const ShaderProgram& shader, const RenderScene& scene, bool samples_light,
                                   glm::ivec2 viewport, int unit) {
  const std::array<glm::vec3, 3> axes = environment_axes(scene);
  shader.set_vec3("u_environment_axes", glm::value_ptr(axes[0]), 3);
  set_map(scene);
  TextureBinder binder(shader, unit);
  binder.bind("u_environment_map", map_);
  if (samples_light) {
    shader.set("u_light_total", static_cast<float>(light_->sampler.total()));
    set_sample(shader, scene, 0, kEnvironmentSampleCount);
    return;
  }
  set_smooth(shader, light_->smooth);
  Tables& tables = tables_.of(scene.brdf, [this](const Brdf& brdf) { return make_tables(brdf); });
  binder.bind("u_reflection_table", tables.texture);
  if (!tables.term_spreads.empty())
    shader.set_floats("u_environment_spreads", tables.term_spreads.data(),
                      static_cast<int>(tables.term_spreads.size()));
  std::vector<float> spreads;
  for (const double spread : light_->levels.spreads) spreads.push_back(static_cast<float>(spread));
  shader.set_floats("u_level_spreads", spreads.data(), static_cast<int>(spreads.size()));
  shader.set("u_level_count", static_cast<int>(spreads.size()));
  if (scene.environment_mode != EnvironmentMode::kHarmonics || scene.brdf.kind == BrdfKind::kLambert) return;
  set_half_vector_light(scene, viewport);
  binder.bind("u_half_vector_light", half_vector_light_);
  const glm::vec2 grid(kGridColumns, kGridRows), size(viewport);
  shader.set_vec2("u_half_grid", glm::value_ptr(grid));
  shader.set_vec2("u_viewport", glm::value_ptr(size));
  if (tables.half_zonal.empty())
    for (const glm::dvec3& coefficient : zonal_coefficients(scene.brdf, kHalfVectorOrder))
      tables.half_zonal.emplace_back(coefficient);
  shader.set_vec3("u_half_zonal", glm::value_ptr(tables.half_zonal[0]), kHalfVectorOrder + 1);
}

}  // namespace multum::gl
