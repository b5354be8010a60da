// SPDX-License-Identifier: Apache-2.0
#include "tests/gl/glsl/environment_inputs.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

const glm::dvec3 kRadiance(0.2, 0.5, 0.8), kReflected(0.7, 0.6, 0.5);

}  // namespace

ShaderHarnessInput environment_variant(const std::string& texts) {
  ShaderHarnessInput variant;
  variant.flags = {"MULTUM_ENVIRONMENT", "MULTUM_ENVIRONMENT_TERMS 1"};
  variant.formulas = std::string(shader_light_environment_frame_glsl) + shader_light_environment_glsl +
                     shader_light_environment_levels_glsl + texts;
  return variant;
}

Texture flat_texture(const GlFunctions& gl, const glm::vec4& value) {
  constexpr int kSide = 16;
  Texture texture(gl, "flat", {kSide, kSide, kLevelCount}, {WrapMode::kClamp, WrapMode::kClamp, true, 1.0f});
  const std::vector<glm::vec4> texels(kSide * kSide, value);
  for (int level = 0; level < kLevelCount; ++level) texture.upload_level(level, &texels[0].x);
  return texture;
}

glm::dmat3 SmoothLight::quadratic() { return {0.5, 0.2, 0.1, 0.2, -0.3, 0.0, 0.1, 0.0, -0.2}; }

// Integrates over rings about n. The integrand is smooth: a polynomial of degree 3 in the cosine to n, and three
// frequencies around n.
double SmoothLight::irradiance(const glm::dvec3& n) const {
  constexpr int kRings = 200, kAround = 8;
  const glm::dvec3 along =
      glm::normalize(glm::cross(n, std::abs(n.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
  const glm::dvec3 across = glm::cross(n, along);
  double sum = 0.0;
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < kAround; ++j) {
      const double t = (i + 0.5) / kRings, side = std::sqrt(1.0 - t * t), phi = 2.0 * M_PI * j / kAround;
      const glm::dvec3 l = t * n + side * (std::cos(phi) * along + std::sin(phi) * across);
      sum += t * (mean + glm::dot(linear, l) + glm::dot(l, quadratic() * l));
    }
  return sum * 2.0 * M_PI / (kRings * kAround);
}

void set_smooth_light(const ShaderProgram& program, const SmoothLight& light) {
  const glm::vec3 mean(static_cast<float>(light.mean));
  std::vector<glm::vec3> linear(3, glm::vec3(light.linear)), quadratic;
  for (int channel = 0; channel < 3; ++channel)
    for (int row = 0; row < 3; ++row) quadratic.emplace_back(SmoothLight::quadratic()[row]);
  program.set_vec3("u_smooth_mean", &mean.x, 1);
  program.set_vec3("u_smooth_linear", glm::value_ptr(linear[0]), 3);
  program.set_vec3("u_smooth_quadratic", glm::value_ptr(quadratic[0]), 9);
}

void set_levels(const ShaderProgram& program) {
  const float of_term = 0.01f;
  program.set_floats("u_level_spreads", kLevelSpreads, kLevelCount);
  program.set("u_level_count", kLevelCount);
  program.set_floats("u_environment_spreads", &of_term, 1);
}

ConstantLight::ConstantLight(const GlFunctions& gl)
    : map_(flat_texture(gl, glm::vec4(kRadiance, 1.0))), table_(flat_texture(gl, glm::vec4(kReflected, 1.0))) {}

void ConstantLight::set(const ShaderProgram& program) const {
  const glm::vec3 mean(kRadiance);
  const std::vector<glm::vec3> none(9, glm::vec3(0.0f));
  set_levels(program);
  program.set_vec3("u_smooth_mean", &mean.x, 1);
  program.set_vec3("u_smooth_linear", glm::value_ptr(none[0]), 3);
  program.set_vec3("u_smooth_quadratic", glm::value_ptr(none[0]), 9);
  program.set("u_environment_map", 3);
  program.set("u_reflection_table", 4);
  map_.bind(3);
  table_.bind(4);
}

glm::dvec3 ConstantLight::irradiance() { return M_PI * kRadiance; }
glm::dvec3 ConstantLight::highlight() { return kReflected * kRadiance; }

}  // namespace multum::gl
