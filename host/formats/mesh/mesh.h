// SPDX-License-Identifier: Apache-2.0
// Triangle meshes for rendering a normal map: positions, normals, texture coordinates and tangent frames.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace multum {

/// Triangles with one material.
struct MeshPart {
  std::string material;    // name in the file; may be empty
  int material_index = 0;  // index in the file's order
  std::uint32_t first_index = 0, index_count = 0;
};

/// All vertices of the meshes of a file in one list, in world space.
struct TriangleMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;      // unit vectors
  std::vector<glm::vec4> tangents;     // unit vectors along growing u, orthogonal to the normal; w is +1 or -1, and
                                       // bitangent = w * cross(normal, tangent), along growing v
  std::vector<glm::vec2> uvs;          // v grows upwards in the image, for every file format
  std::vector<std::uint32_t> indices;  // three per triangle
  std::vector<MeshPart> parts;         // ranges of triangles by material, in the order of the indices
};

/// Reads OBJ, glTF, GLB and other formats that assimp supports. Applies node transforms, and makes missing normals and
/// tangents. Tangents follow MikkTSpace's convention (tangent_space.h). `uv_set` 0 is TEXCOORD_0. If the file has
/// tangents, they belong to the texture coordinates of its normal maps. Throws Error(kInput), which names the file and
/// the fault. The faults are missing texture coordinates, indices out of range, coordinates that are not finite, and a
/// required extension that cannot be read.
TriangleMesh read_mesh(const std::string& path, int uv_set = 0);

/// Makes the square from (-size/2, 0, 0) to (size/2, size, 0), with normal +Z and uv 0..1.
TriangleMesh make_plane(float size);

}  // namespace multum
