// SPDX-License-Identifier: Apache-2.0
// Tangents by MikkTSpace's convention (M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, and
// mikktspace.com), which glTF 2.0 requires (section 3.7.2.1). Normal maps from other programs then look right in this
// program. The code was written from this description:
//
//   triangle        T = (v_2 e_1 - v_1 e_2) / area, along growing u; orientation: the sign of its area in texture space
//   group           triangles around a vertex that share edges and orientation, so that mirrored charts never mix
//   vertex          sum over the group of angle * normalise(T - n (n.T)), with the angle between the triangle's edges
//                   projected to the plane across n; normalised. Its handedness w is the group's orientation.
//   fragment        bitangent = w cross(n, t) of the interpolated normal and tangent
//
// Vertices are equal if position, normal and texture coordinates are equal bit by bit. There are two departures.
// Quadrangles are split into two triangles, whereas MikkTSpace weighs their four corners together. The angle between
// faces never splits a group, as with MikkTSpace's usual threshold of 180 degrees.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace multum {

/// Triangle corners, three per triangle.
struct TriangleCorners {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // unit vectors
  std::vector<glm::vec2> uvs;      // v grows upwards in the image
};

/// Returns a unit tangent for every corner, orthogonal to the normal, with w = +1 or -1. If the triangles of a corner
/// have no area in texture space, the corner gets a neighbour's tangent, or any orthogonal tangent if there is none.
std::vector<glm::vec4> mikk_tangents(const TriangleCorners& corners);

/// Returns any unit vector orthogonal to `n`.
glm::vec3 any_orthogonal(const glm::vec3& n);

}  // namespace multum
