// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/mesh.h"

#include <cmath>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <glm/geometric.hpp>

#include "host/mesh/mesh_import.h"

namespace multum {
namespace {

constexpr unsigned kSteps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_GenSmoothNormals |
                            aiProcess_CalcTangentSpace | aiProcess_JoinIdenticalVertices |
                            aiProcess_PreTransformVertices | aiProcess_ValidateDataStructure;

/// Any unit vector orthogonal to `n`, for vertices where u and v do not grow.
glm::vec3 any_orthogonal(const glm::vec3& n) {
  const glm::vec3 axis = std::abs(n.x) < 0.7f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
  return glm::normalize(axis - n * glm::dot(n, axis));
}

glm::vec4 tangent_frame(const glm::vec3& n, const glm::vec3& tangent, const glm::vec3& bitangent) {
  const glm::vec3 t = tangent - n * glm::dot(n, tangent);
  const float size = glm::length(t);
  if (!(size > 1e-6f) || !is_finite(t)) return glm::vec4(any_orthogonal(n), 1.0f);
  const float handedness = glm::dot(glm::cross(n, t), bitangent) < 0.0f ? -1.0f : 1.0f;
  return glm::vec4(t / size, handedness);
}

void append_vertices(TriangleMesh& mesh, const aiMesh& part, const std::string& path) {
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    const glm::vec3 position = to_vec3(part.mVertices[i]);
    if (!is_finite(position))
      refuse_mesh(path, "vertex " + std::to_string(i) + " of mesh '" + part.mName.C_Str() + "' is not finite");
    glm::vec3 normal = part.HasNormals() ? to_vec3(part.mNormals[i]) : glm::vec3(0.0f);
    const float size = glm::length(normal);
    normal = size > 1e-12f && std::isfinite(size) ? normal / size : glm::vec3(0.0f, 0.0f, 1.0f);
    const aiVector3D uv = part.mTextureCoords[0][i];
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y))
      refuse_mesh(path,
                  "texture coordinate " + std::to_string(i) + " of mesh '" + part.mName.C_Str() + "' is not finite");
    const bool has_frame = part.HasTangentsAndBitangents();
    const glm::vec3 tangent = has_frame ? to_vec3(part.mTangents[i]) : glm::vec3(0.0f);
    const glm::vec3 bitangent = has_frame ? to_vec3(part.mBitangents[i]) : glm::vec3(0.0f);
    mesh.positions.push_back(position);
    mesh.normals.push_back(normal);
    mesh.tangents.push_back(tangent_frame(normal, tangent, bitangent));
    mesh.uvs.emplace_back(uv.x, uv.y);
  }
}

void append_mesh(TriangleMesh& mesh, const aiMesh& part, const std::string& path) {
  if ((part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0) return;  // points and lines are not drawn
  if (!part.HasTextureCoords(0))
    refuse_mesh(
        path, std::string("mesh '") + part.mName.C_Str() + "' has no texture coordinates, so no map can be put on it");
  const auto base = static_cast<std::uint32_t>(mesh.positions.size());
  append_vertices(mesh, part, path);
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      if (face.mIndices[k] >= part.mNumVertices)
        refuse_mesh(path, "triangle " + std::to_string(f) + " of mesh '" + part.mName.C_Str() + "' names vertex " +
                              std::to_string(face.mIndices[k]) + " of " + std::to_string(part.mNumVertices));
      mesh.indices.push_back(base + face.mIndices[k]);
    }
  }
}

}  // namespace

TriangleMesh read_mesh(const std::string& path) {
  const MeshImport import(path, kSteps);
  const aiScene& scene = import.scene();
  TriangleMesh mesh;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) append_mesh(mesh, *scene.mMeshes[i], path);
  if (mesh.indices.empty()) refuse_mesh(path, "holds no triangles");
  return mesh;
}

TriangleMesh make_plane(float size) {
  TriangleMesh plane;
  const float half = 0.5f * size;
  plane.positions = {{-half, 0.0f, 0.0f}, {half, 0.0f, 0.0f}, {half, size, 0.0f}, {-half, size, 0.0f}};
  plane.uvs = {{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}};
  plane.normals.assign(4, {0.0f, 0.0f, 1.0f});
  plane.tangents.assign(4, {1.0f, 0.0f, 0.0f, 1.0f});
  plane.indices = {0, 1, 2, 0, 2, 3};
  return plane;
}

}  // namespace multum
