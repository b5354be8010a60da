// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/fields/object_meshes.h"

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"

namespace multum {

gl::MeshData mapped_mesh_data(const ObjectMesh& mesh, const TextureMapping& mapping) {
  gl::MeshData data;
  const std::vector<glm::vec2> corners = mapped_corners(mesh.uvs, mesh.indices, mapping);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    gl::MeshVertex vertex{};
    vertex.position = mesh.positions[mesh.indices[i]];
    vertex.uv = corners[i];
    data.vertices.push_back(vertex);
    data.indices.push_back(static_cast<std::uint32_t>(i));
  }
  return data;
}

std::string mesh_data_hash(const gl::MeshData& data) {
  ContentHash hash;
  for (const gl::MeshVertex& vertex : data.vertices) {
    hash.update(&vertex.position, sizeof(vertex.position));
    hash.update(&vertex.uv, sizeof(vertex.uv));
  }
  hash.update(data.indices.data(), data.indices.size() * sizeof(data.indices[0]));
  return hash.finish();
}

glm::mat4 object_to_clip(const glm::dmat4& world_to_clip, const glm::dmat4& object_to_world) {
  return glm::mat4(world_to_clip * object_to_world);
}

std::size_t find_object(const std::vector<ObjectMesh>& meshes, const std::string& name, const std::string& path) {
  std::string known;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    if (meshes[i].name == name) return i;
    known += (i == 0 ? "" : ", ") + meshes[i].name;
  }
  throw Error(ErrorCode::kInput, path + ": has no object '" + name + "'; it has " + known);
}

}  // namespace multum
