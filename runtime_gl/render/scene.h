// SPDX-License-Identifier: Apache-2.0
// What is drawn and how, as plain settings.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/brdf/brdf.h"
#include "runtime_gl/render/camera.h"

namespace multum::gl {

constexpr int kLightCountMax = 8;  // of each kind

struct Light {
  glm::vec3 direction{0.3f, 0.8f, 0.5f};  // towards the light, any length > 0
  glm::vec3 irradiance{3.14159265f};      // on a surface that faces it
};

struct PointLight {
  glm::vec3 position{0.0f, 0.0f, 1.0f};
  glm::vec3 intensity{1.0f};  // irradiance at distance 1 of a surface that faces it
};

struct Scene {
  Camera camera;
  std::vector<Light> lights{Light{}};
  std::vector<PointLight> point_lights;
  Brdf brdf;
  float uv_scale = 1.0f;  // repeats of the map per unit of uv
};

}  // namespace multum::gl
