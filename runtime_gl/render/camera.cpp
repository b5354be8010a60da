// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "host/foundation/base/error.h"

namespace multum::gl {

glm::mat4 view_projection(const Camera& camera, int width, int height, glm::vec2 jitter) {
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  const glm::mat4 projection =
      glm::perspective(glm::radians(camera.fov_y_degrees), aspect, camera.near_distance, camera.far_distance);
  const glm::vec3 shift(2.0f * jitter.x / static_cast<float>(width), 2.0f * jitter.y / static_cast<float>(height),
                        0.0f);
  return glm::translate(glm::mat4(1.0f), shift) * projection * glm::lookAt(camera.eye, camera.target, camera.up);
}

namespace {

constexpr float kFilled = 0.94f;  // share of the picture's half width or height that the points fill

struct AxisPoint {
  float x, z;  // x is along an axis of the picture, z towards the eye, both from the middle
};

// Returns the least distance of the eye, at the best offset, for which `|x - offset| <= t * (distance - z)` holds for
// all points. The condition means `x + t * z <= t * distance + offset` and `t * z - x <= t * distance - offset`.
float distance_to_fit(const std::vector<AxisPoint>& points, float t) {
  float most = -std::numeric_limits<float>::max(), least = most;
  for (const AxisPoint& p : points) {
    most = std::max(most, t * p.z + p.x);
    least = std::max(least, t * p.z - p.x);
  }
  return 0.5f * (most + least) / t;
}

// Returns the eye's offset at which the points extend equally far to both sides of the picture. The sum of the two
// extents falls as the offset grows.
float offset_to_centre(const std::vector<AxisPoint>& points, float distance, float radius) {
  float low = -radius, high = radius;
  for (int step = 0; step < 20; ++step) {  // precise to a millionth of the radius
    const float offset = 0.5f * (low + high);
    float most = -std::numeric_limits<float>::max(), least = std::numeric_limits<float>::max();
    for (const AxisPoint& p : points) {
      const float slope = (p.x - offset) / (distance - p.z);
      most = std::max(most, slope);
      least = std::min(least, slope);
    }
    (most + least > 0.0f ? low : high) = offset;
  }
  return 0.5f * (low + high);
}

}  // namespace

Camera frame_points(const std::vector<glm::vec3>& points, const glm::vec3& up, float aspect) {
  MULTUM_CHECK(!points.empty());
  glm::vec3 low = points[0], high = low;
  for (const glm::vec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const float radius = std::max(0.5f * glm::length(high - low), 1e-6f);
  const glm::vec3 middle = 0.5f * (low + high);
  Camera camera;
  camera.up = up;
  // If +Y is up, the front is +Z, as in glTF. If +Z is up, the front is -Y.
  const glm::vec3 side = std::abs(up.x) < 0.9f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0.0f, 0.0f, -1.0f);
  const glm::vec3 front = glm::normalize(glm::cross(side, up));
  const glm::vec3 back = glm::normalize(0.5f * glm::cross(up, front) + 0.45f * up + front);
  const glm::vec3 right = glm::normalize(glm::cross(up, back));
  const glm::vec3 above = glm::cross(back, right);
  const float tangent = kFilled * std::tan(glm::radians(0.5f * camera.fov_y_degrees));
  std::vector<AxisPoint> across, upwards;
  float nearest = -radius, farthest = radius;  // distances along `back`
  for (const glm::vec3& point : points) {
    const glm::vec3 p = point - middle;
    const float z = glm::dot(p, back);
    across.push_back({glm::dot(p, right), z});
    upwards.push_back({glm::dot(p, above), z});
    nearest = std::max(nearest, z);
    farthest = std::min(farthest, z);
  }
  // Keeps the eye in front of the nearest point.
  const float distance =
      std::max({distance_to_fit(across, tangent * aspect), distance_to_fit(upwards, tangent), nearest + 0.2f * radius});
  camera.target =
      middle + offset_to_centre(across, distance, radius) * right + offset_to_centre(upwards, distance, radius) * above;
  camera.eye = camera.target + distance * back;
  camera.near_distance = 0.5f * (distance - nearest);
  camera.far_distance = distance - farthest + radius;
  return camera;
}

Camera moved_away(const Camera& camera, float factor) {
  Camera moved = camera;
  const glm::vec3 view = camera.eye - camera.target;
  moved.eye = camera.target + factor * view;
  // The amount by which the distance of every point increases along the line of sight.
  const float farther = (factor - 1.0f) * glm::length(view);
  moved.near_distance = farther > 0.0f ? camera.near_distance + farther : factor * camera.near_distance;
  moved.far_distance = camera.far_distance + std::max(farther, 0.0f);
  return moved;
}

}  // namespace multum::gl
