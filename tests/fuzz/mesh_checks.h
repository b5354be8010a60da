// SPDX-License-Identifier: Apache-2.0
// Checks the properties that every accepted mesh must have.
#pragma once

#include <cmath>

#include "host/formats/decoder/libraries/mesh_readers.h"
#include "host/formats/mesh/mesh_messages.h"
#include "tests/fuzz/fuzz.h"

namespace multum::fuzz {

template <typename Mesh>
void check_indices(const Mesh& mesh) {
  MULTUM_CHECK(mesh.uvs.size() == mesh.positions.size() && mesh.indices.size() % 3 == 0);
  for (const std::uint32_t index : mesh.indices) MULTUM_CHECK(index < mesh.positions.size());
}

inline void check(const TriangleMesh& mesh) {
  MULTUM_CHECK(mesh.normals.size() == mesh.positions.size() && mesh.tangents.size() == mesh.positions.size());
  for (const MeshPart& part : mesh.parts) MULTUM_CHECK(part.first_index + part.index_count <= mesh.indices.size());
  check_indices(mesh);
}
inline void check(const ObjectMeshes& meshes) {
  for (const ObjectMesh& mesh : meshes) check_indices(mesh);
}

inline void read_whole(const std::string& path) {
  const TriangleMesh mesh = import_mesh(path, 0);
  check(mesh);
  for (const glm::vec3& normal : mesh.normals) MULTUM_CHECK(std::isfinite(normal.x + normal.y + normal.z));
}
inline void read_objects(const std::string& path) { check(import_object_meshes(path, 0)); }

}  // namespace multum::fuzz
