// SPDX-License-Identifier: Apache-2.0
// Maps normals to points of a reflectance map (Williams 1983, section 4): Lambert's azimuthal equal-area projection
// about the direction to the viewer, who is distant, as the lights are.
//
//     (x, y, z)   the normal, z towards the viewer       p = (x, y) sqrt(2 / (1 + z)),  |p| = 2 sin(angle / 2)
//     s = 1/2 + p_x / (2 sqrt 2),  t = 1/2 - p_y / (2 sqrt 2)
//
//      +-------------+     circle: normals at right angles to the viewer's direction, |p| = sqrt 2
//      |  .-'''''-.  |     corners: the normal away from the viewer, |p| = 2
//      | /         \ |
//      | |  viewer | |     Every texel has the same solid angle, 8 / size^2, so that an average over texels is one over
//      | \         / |     solid angle and a level means the same everywhere. Williams indexes by x and y themselves:
//      |  '-.....-'  |     his map ends at the circle, where a texel's solid angle grows without bound; this one goes
//      +-------------+     on behind it, so that filters at a silhouette find what belongs there.
//
// Distortion: lengths along and across are cos(a/2) and 1 / cos(a/2) of their size at the centre: sqrt 2 and its
// inverse on the circle.
#pragma once

#include <string>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace multum {

/// World directions, unit and orthogonal.
struct ReflectanceFrame {
  glm::dvec3 right{1.0, 0.0, 0.0};
  glm::dvec3 up{0.0, 1.0, 0.0};
  glm::dvec3 viewer{0.0, 0.0, 1.0};
};

/// `viewer`: towards the viewer, any length > 0. `up`: roughly; another one is taken where it is along `viewer`.
ReflectanceFrame reflectance_frame(const glm::dvec3& viewer, const glm::dvec3& up);

/// s, t of a unit normal in world space. The one away from the viewer lies in every corner: the first one is given.
glm::dvec2 reflectance_place(const ReflectanceFrame& frame, const glm::dvec3& normal);
/// The unit normal there.
glm::dvec3 reflectance_normal(const ReflectanceFrame& frame, const glm::dvec2& place);

/// Side of the square that is mapped to 0..1.
constexpr double kReflectanceSide = 2.8284271247461903;

/// Writes the frame as the file's settings have it ("frame"), and reads it. Throws Error(kInput) naming `path`.
std::string reflectance_frame_json(const ReflectanceFrame& frame);
ReflectanceFrame parse_reflectance_frame(const std::string& settings, const std::string& path);

}  // namespace multum
