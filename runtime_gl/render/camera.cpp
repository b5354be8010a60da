// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/camera.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace multum::gl {

glm::mat4 view_projection(const Camera& camera, int width, int height, glm::vec2 jitter) {
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  const glm::mat4 projection =
      glm::perspective(glm::radians(camera.fov_y_degrees), aspect, camera.near_distance, camera.far_distance);
  const glm::vec3 shift(2.0f * jitter.x / static_cast<float>(width), 2.0f * jitter.y / static_cast<float>(height),
                        0.0f);
  return glm::translate(glm::mat4(1.0f), shift) * projection * glm::lookAt(camera.eye, camera.target, camera.up);
}

Camera frame_box(const glm::vec3& low, const glm::vec3& high, const glm::vec3& up) {
  Camera camera;
  const float radius = std::max(0.5f * glm::length(high - low), 1e-6f);
  camera.target = 0.5f * (low + high);
  camera.up = up;
  // With +Y up the front is +Z, as in glTF; with +Z up it is -Y.
  const glm::vec3 side = std::abs(up.x) < 0.9f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0.0f, 0.0f, -1.0f);
  const glm::vec3 front = glm::normalize(glm::cross(side, up));
  const glm::vec3 right = glm::cross(up, front);
  const float distance = radius / std::sin(glm::radians(0.5f * camera.fov_y_degrees));
  camera.eye = camera.target + distance * glm::normalize(0.5f * right + 0.45f * up + front);
  camera.near_distance = 0.05f * radius;
  camera.far_distance = distance + 2.0f * radius;
  return camera;
}

}  // namespace multum::gl
