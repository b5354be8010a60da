// SPDX-License-Identifier: Apache-2.0
// Reads all meshes of a file as one list of triangles.
#include "host/formats/decoder/libraries/mesh_readers.h"

#include <array>
#include <cmath>
#include <map>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "host/formats/decoder/libraries/assimp_scene.h"
#include "host/formats/mesh/tangent_space.h"

namespace multum {
namespace {

// assimp must not compute tangents or join vertices. It averages tangents without weights, even across mirrored charts,
// and merges positions that are closer than 1e-5, no matter what the unit is.
constexpr unsigned kMeshSteps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_GenSmoothNormals |
                                aiProcess_PreTransformVertices | aiProcess_ValidateDataStructure;

// The corners of the triangles of a part, with the file's own tangents if it has any.
struct PartCorners {
  TriangleCorners corners;
  std::vector<glm::vec4> tangents;
};

glm::vec4 tangent_frame(const glm::vec3& n, const glm::vec3& tangent, const glm::vec3& bitangent) {
  const glm::vec3 t = tangent - n * glm::dot(n, tangent);
  const float size = glm::length(t);
  if (!(size > 1e-6f) || !is_finite(t)) return glm::vec4(any_orthogonal(n), 1.0f);
  const float handedness = glm::dot(glm::cross(n, t), bitangent) < 0.0f ? -1.0f : 1.0f;
  return glm::vec4(t / size, handedness);
}

class PartReader {
 public:
  PartReader(const std::string& path, const aiMesh& part, unsigned uv_set)
      : path_(path), part_(part), uv_set_(uv_set) {}

  PartCorners read() {
    if (!part_.HasTextureCoords(uv_set_))
      refuse_file(path_, fmt::format("mesh '{}' has no texture coordinates{}, so a map cannot be applied",
                                     part_.mName.C_Str(), uv_set_ == 0 ? "" : fmt::format(" of set {}", uv_set_)));
    for (unsigned f = 0; f < part_.mNumFaces; ++f)
      for (unsigned k = 0; k < part_.mFaces[f].mNumIndices; ++k) append(f, part_.mFaces[f].mIndices[k]);
    if (!part_.HasTangentsAndBitangents()) result_.tangents = mikk_tangents(result_.corners);
    return std::move(result_);
  }

 private:
  void append(unsigned face, unsigned i) {
    const char* const name = part_.mName.C_Str();
    if (i >= part_.mNumVertices)
      refuse_file(path_,
                  fmt::format("triangle {} of mesh '{}' refers to vertex {} of {}", face, name, i, part_.mNumVertices));
    const glm::vec3 position = to_vec3(part_.mVertices[i]);
    if (!is_finite(position)) refuse_file(path_, fmt::format("vertex {} of mesh '{}' is not finite", i, name));
    glm::vec3 normal = part_.HasNormals() ? to_vec3(part_.mNormals[i]) : glm::vec3(0.0f);
    const float size = glm::length(normal);
    normal = size > 1e-12f && std::isfinite(size) ? normal / size : glm::vec3(0.0f, 0.0f, 1.0f);
    const aiVector3D uv = part_.mTextureCoords[uv_set_][i];
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y))
      refuse_file(path_, fmt::format("texture coordinate {} of mesh '{}' is not finite", i, name));
    result_.corners.positions.push_back(position);
    result_.corners.normals.push_back(normal);
    result_.corners.uvs.emplace_back(uv.x, uv.y);
    if (part_.HasTangentsAndBitangents())
      result_.tangents.push_back(tangent_frame(normal, to_vec3(part_.mTangents[i]), to_vec3(part_.mBitangents[i])));
  }

  const std::string& path_;
  const aiMesh& part_;
  const unsigned uv_set_;
  PartCorners result_;
};

// Appends a part. Corners with identical attributes become one vertex.
void append_part(TriangleMesh& mesh, const PartCorners& part) {
  using Vertex = std::array<float, 12>;
  std::map<Vertex, std::uint32_t> numbers;
  for (std::size_t i = 0; i < part.tangents.size(); ++i) {
    const glm::vec3 &p = part.corners.positions[i], &n = part.corners.normals[i];
    const glm::vec4& t = part.tangents[i];
    const glm::vec2& uv = part.corners.uvs[i];
    const auto [place, is_new] =
        numbers.try_emplace(Vertex{p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y, t.z, t.w, uv.x, uv.y},
                            static_cast<std::uint32_t>(mesh.positions.size()));
    if (is_new) {
      mesh.positions.push_back(p);
      mesh.normals.push_back(n);
      mesh.tangents.push_back(t);
      mesh.uvs.push_back(uv);
    }
    mesh.indices.push_back(place->second);
  }
}

}  // namespace

TriangleMesh import_mesh(const std::string& path, int uv_set) {
  if (uv_set < 0 || uv_set >= AI_MAX_NUMBER_OF_TEXTURECOORDS)
    refuse_file(path, fmt::format("texture coordinate set is {}, expected 0 to {}", uv_set,
                                  AI_MAX_NUMBER_OF_TEXTURECOORDS - 1));
  const MeshImport import(path, kMeshSteps);
  const aiScene& scene = import.scene();
  TriangleMesh mesh;
  for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
    const aiMesh& part = *scene.mMeshes[i];
    if ((part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0) continue;  // points and lines are not drawn
    MeshPart made;
    made.material_index = static_cast<int>(part.mMaterialIndex);
    if (part.mMaterialIndex < scene.mNumMaterials)
      made.material = scene.mMaterials[part.mMaterialIndex]->GetName().C_Str();
    made.first_index = static_cast<std::uint32_t>(mesh.indices.size());
    append_part(mesh, PartReader(path, part, static_cast<unsigned>(uv_set)).read());
    made.index_count = static_cast<std::uint32_t>(mesh.indices.size()) - made.first_index;
    mesh.parts.push_back(made);
  }
  if (mesh.indices.empty()) refuse_file(path, "holds no triangles");
  return mesh;
}

}  // namespace multum
