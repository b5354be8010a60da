// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/light_shading.h"

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "host/foundation/base/error.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {

ShaderParts light_shader_parts(const RenderScene& scene) {
  ShaderParts parts{{}, {shader_light_lights_glsl}};
  if (!scene.lights.empty()) parts.flags.push_back("MULTUM_DIRECTIONAL_LIGHTS " + std::to_string(scene.lights.size()));
  if (!scene.point_lights.empty())
    parts.flags.push_back("MULTUM_POINT_LIGHTS " + std::to_string(scene.point_lights.size()));
  return parts;
}

namespace {

void set_vectors(const ShaderProgram& shader, const char* uniform, const std::vector<glm::vec3>& values) {
  if (!values.empty()) shader.set_vec3(uniform, glm::value_ptr(values[0]), static_cast<int>(values.size()));
}

}  // namespace

void set_lights(const ShaderProgram& shader, const RenderScene& scene) {
  MULTUM_CHECK(scene.lights.size() <= kLightCountMax && scene.point_lights.size() <= kLightCountMax);
  std::vector<glm::vec3> directions, irradiances, positions, intensities;
  for (const Light& light : scene.lights) {
    directions.push_back(glm::normalize(light.direction));
    irradiances.push_back(light.irradiance);
  }
  for (const PointLight& light : scene.point_lights) {
    positions.push_back(light.position);
    intensities.push_back(light.intensity);
  }
  set_vectors(shader, "u_light_directions", directions);
  set_vectors(shader, "u_light_irradiances", irradiances);
  set_vectors(shader, "u_point_positions", positions);
  set_vectors(shader, "u_point_intensities", intensities);
}

}  // namespace multum::gl
