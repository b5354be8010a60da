// SPDX-License-Identifier: Apache-2.0
// A pinhole camera.
#pragma once

#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace multum::gl {

struct Camera {
  // The default camera looks over the plane z = 0 from a height of 0.3 units. The nearest row of pixels is at 0.45
  // units, where maps with fewer than 1024 texels per unit are magnified. The farthest row is at 11 units, 1.5 degrees
  // below the horizon. The horizon is not visible.
  glm::vec3 eye{0.0f, 0.0f, 0.3f};
  glm::vec3 target{0.0f, 1.0f, -0.0939f};  // the camera looks down by 21.5 degrees
  glm::vec3 up{0.0f, 0.0f, 1.0f};
  float fov_y_degrees = 40.0f;  // 1..170
  float near_distance = 0.01f;
  float far_distance = 100.0f;
};

/// `jitter` is the picture's shift in pixels, -0.5 to 0.5 in each direction.
glm::mat4 view_projection(const Camera& camera, int width, int height, glm::vec2 jitter);

/// Returns a camera that sees all these points from the front, slightly from above and from the right. The points fill
/// as much of a picture of this aspect (width / height) as possible. `up` is a unit vector.
Camera frame_points(const std::vector<glm::vec3>& points, const glm::vec3& up, float aspect);

/// Returns the same view from `factor` times the distance to the target. The same points are between its near and far
/// planes.
Camera moved_away(const Camera& camera, float factor);

}  // namespace multum::gl
