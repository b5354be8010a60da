// SPDX-License-Identifier: Apache-2.0
// A pinhole camera.
#pragma once

#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace multum::gl {

struct Camera {
  // The default looks over the plane z = 0 from 0.3 units up: its nearest row of pixels lies at 0.45 units (magnified
  // for maps below 1024 texels a unit), its farthest at 11 units, 1.5 degrees under the horizon, which stays out of
  // sight.
  glm::vec3 eye{0.0f, 0.0f, 0.3f};
  glm::vec3 target{0.0f, 1.0f, -0.0939f};  // 21.5 degrees down
  glm::vec3 up{0.0f, 0.0f, 1.0f};
  float fov_y_degrees = 40.0f;  // 1..170
  float near_distance = 0.01f;
  float far_distance = 100.0f;
};

/// `jitter`: the picture's shift in pixels, -0.5..0.5 each.
glm::mat4 view_projection(const Camera& camera, int width, int height, glm::vec2 jitter);

/// A camera that sees all of these points, from the front, a little above and to the right, as large as they fit into a
/// picture of this aspect (width / height). `up`: unit.
Camera frame_points(const std::vector<glm::vec3>& points, const glm::vec3& up, float aspect);

/// The same view from `factor` times as far from the target; what lay between the near and the far plane still does.
Camera moved_away(const Camera& camera, float factor);

}  // namespace multum::gl
