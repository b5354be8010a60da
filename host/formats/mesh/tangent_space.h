// SPDX-License-Identifier: Apache-2.0
// Tangents as normal maps are baked for: MikkTSpace's convention (M. Mikkelsen, "Simulation of Wrinkled Surfaces
// Revisited", 2008, and mikktspace.com; glTF 2.0 asks for it, section 3.7.2.1), so that a map baked in one program
// looks the same here. Written from the description:
//
//   triangle        T = (v_2 e_1 - v_1 e_2) / area, along growing u; orientation: the sign of its area in texture space
//   group           triangles around a vertex that share edges and orientation: mirrored charts never mix
//   vertex          sum over the group of angle * normalise(T - n (n.T)), the angle between the triangle's edges as
//                   they lie in the plane across n; normalised. Its handedness w is the group's orientation.
//   fragment        bitangent = w cross(n, t) of the interpolated normal and tangent
//
// A vertex is told from others by position, normal and texture coordinates, bit by bit. Two departures: quadrangles
// come as two triangles (MikkTSpace weighs their four corners at once), and the angle between faces never splits a
// group (MikkTSpace's usual threshold of 180 degrees does not either).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace multum {

/// Corners of triangles, three a triangle.
struct TriangleCorners {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // unit
  std::vector<glm::vec2> uvs;      // v grows upwards in the image
};

/// A tangent for every corner: unit, orthogonal to the normal; w = +1 or -1. Corners whose triangles have no direction
/// of growing u (no area in texture space) take a neighbour's, else any orthogonal one.
std::vector<glm::vec4> mikk_tangents(const TriangleCorners& corners);

/// Any unit vector orthogonal to `n`.
glm::vec3 any_orthogonal(const glm::vec3& n);

}  // namespace multum
