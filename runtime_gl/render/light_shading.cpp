// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/light_shading.h"

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "host/base/error.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {

ShaderParts light_shader_parts(const Scene& scene) {
  ShaderParts parts{{}, {shader_light_lights_glsl}};
  if (!scene.lights.empty()) parts.flags.push_back("MULTUM_DIRECTIONAL_LIGHTS " + std::to_string(scene.lights.size()));
  return parts;
}

void set_lights(const ShaderProgram& shader, const Scene& scene) {
  MULTUM_CHECK(scene.lights.size() <= kLightCountMax);
  if (scene.lights.empty()) return;
  std::vector<glm::vec3> directions, irradiances;
  for (const Light& light : scene.lights) {
    directions.push_back(glm::normalize(light.direction));
    irradiances.push_back(light.irradiance);
  }
  const int count = static_cast<int>(scene.lights.size());
  shader.set_vec3("u_light_directions", glm::value_ptr(directions[0]), count);
  shader.set_vec3("u_light_irradiances", glm::value_ptr(irradiances[0]), count);
}

}  // namespace multum::gl
