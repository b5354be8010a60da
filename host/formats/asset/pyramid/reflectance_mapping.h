// SPDX-License-Identifier: Apache-2.0
// Maps normals to points of a reflectance map (Williams 1983, section 4), by Lambert's azimuthal equal-area projection
// about the direction to the viewer. Viewer and lights are distant.
//
//     (x, y, z)   the normal, z towards the viewer       p = (x, y) sqrt(2 / (1 + z)),  |p| = 2 sin(angle / 2)
//     s = 1/2 + p_x / (2 sqrt 2),  t = 1/2 - p_y / (2 sqrt 2)
//
//      +-------------+     circle: normals at right angles to the viewer's direction, |p| = sqrt 2
//      |  .-'''''-.  |     corners: the normal away from the viewer, |p| = 2
//      | /         \ |
//      | |  viewer | |     Every texel has the same solid angle, 8 / size^2. So an average over texels is an average
//      | \         / |     over solid angle, and a level has the same meaning everywhere. Williams indexes by x and y:
//      |  '-.....-'  |     his map ends at the circle, where the solid angle of a texel is unbounded. This map goes
//      +-------------+     on outside the circle, so that filters at a silhouette find the right values.
//
// Distortion at angle a from the centre: lengths along the radius are scaled by cos(a/2), and lengths across the radius
// by 1 / cos(a/2). On the circle these factors are 1 / sqrt 2 and sqrt 2.
#pragma once

#include <string>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace multum {

/// Orthogonal unit vectors in world space.
struct ReflectanceFrame {
  glm::dvec3 right{1.0, 0.0, 0.0};
  glm::dvec3 up{0.0, 1.0, 0.0};
  glm::dvec3 viewer{0.0, 0.0, 1.0};
};

/// Makes a frame. `viewer` points towards the viewer, and may have any length > 0. `up` does not have to be exact. If
/// it is parallel to `viewer`, another direction is used.
ReflectanceFrame reflectance_frame(const glm::dvec3& viewer, const glm::dvec3& up);

/// Returns s and t of a unit normal in world space. The normal that points away from the viewer maps to every corner.
/// For this normal, the function returns the first corner.
glm::dvec2 reflectance_place(const ReflectanceFrame& frame, const glm::dvec3& normal);
/// Returns the unit normal at `place`.
glm::dvec3 reflectance_normal(const ReflectanceFrame& frame, const glm::dvec2& place);

/// The side of the square of points p that is mapped to 0..1.
constexpr double kReflectanceSide = 2.8284271247461903;

/// Write and read the frame, which is stored as "frame" in the settings of the file. The reader throws Error(kInput),
/// which names `path`.
std::string reflectance_frame_json(const ReflectanceFrame& frame);
ReflectanceFrame parse_reflectance_frame(const std::string& settings, const std::string& path);

}  // namespace multum
