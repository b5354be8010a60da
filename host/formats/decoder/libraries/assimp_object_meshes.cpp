// SPDX-License-Identifier: Apache-2.0
// Flattens assimp's node tree to one object for each node that has triangles. Only equal vertices are joined, and this
// is done here because assimp merges positions that are closer than 1e-5, no matter what the unit is.
#include "host/formats/decoder/libraries/mesh_readers.h"

#include <array>
#include <cmath>
#include <map>
#include <set>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include "host/formats/decoder/libraries/assimp_scene.h"

namespace multum {
namespace {

constexpr unsigned kObjectMeshSteps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_ValidateDataStructure;

// assimp stores the rows a, b, c and d, but glm stores columns.
glm::dmat4 to_dmat4(const aiMatrix4x4& m) {
  glm::dmat4 result;
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned column = 0; column < 4; ++column)
      result[static_cast<int>(column)][static_cast<int>(row)] = static_cast<double>(m[row][column]);
  return result;
}

bool is_finite(const glm::dmat4& m) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      if (!std::isfinite(m[column][row])) return false;
  return true;
}

class ObjectReader {
 public:
  ObjectReader(const std::string& path, const aiScene& scene, int uv_set)
      : path_(path), scene_(scene), uv_set_(static_cast<unsigned>(uv_set)) {}

  void read(const aiNode& node, const glm::dmat4& parent_to_world) {
    const glm::dmat4 node_to_world = parent_to_world * to_dmat4(node.mTransformation);
    read_object(node, node_to_world);
    for (unsigned i = 0; i < node.mNumChildren; ++i) read(*node.mChildren[i], node_to_world);
  }
  std::vector<ObjectMesh> objects;

 private:
  using Vertex = std::array<float, 5>;  // x, y, z, u, v

  [[noreturn]] void refuse(const ObjectMesh& object, const std::string& what) const {
    refuse_file(path_, fmt::format("object '{}' {}", object.name, what));
  }

  void read_object(const aiNode& node, const glm::dmat4& node_to_world) {
    ObjectMesh object;
    object.name = node.mName.C_Str();
    object.object_to_world = node_to_world;
    vertices_.clear();
    for (unsigned i = 0; i < node.mNumMeshes; ++i) append(object, *scene_.mMeshes[node.mMeshes[i]]);
    if (object.indices.empty()) return;
    if (!is_finite(node_to_world)) refuse(object, "has a transform matrix that is not finite");
    if (!names_.insert(object.name).second) refuse(object, "occurs twice; expected unique object names");
    objects.push_back(std::move(object));
  }

  void append(ObjectMesh& object, const aiMesh& part) {
    if ((part.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0) return;  // points and lines are not drawn
    if (!part.HasTextureCoords(uv_set_))
      refuse(object, fmt::format("has no texture coordinates in set {0} (TEXCOORD_{0})", uv_set_));
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        if (face.mIndices[k] >= part.mNumVertices)
          refuse(object,
                 fmt::format("has a triangle that refers to vertex {} of {}", face.mIndices[k], part.mNumVertices));
        object.indices.push_back(index_of(object, part, face.mIndices[k]));
      }
    }
  }

  std::uint32_t index_of(ObjectMesh& object, const aiMesh& part, unsigned i) {
    const glm::vec3 position = to_vec3(part.mVertices[i]);
    const aiVector3D& uv = part.mTextureCoords[uv_set_][i];
    if (!multum::is_finite(position)) refuse(object, fmt::format("has a vertex {} that is not finite", i));
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y))
      refuse(object, fmt::format("has a texture coordinate {} that is not finite", i));
    const auto [place, is_new] = vertices_.try_emplace(Vertex{position.x, position.y, position.z, uv.x, uv.y},
                                                       static_cast<std::uint32_t>(object.positions.size()));
    if (is_new) {
      object.positions.push_back(position);
      object.uvs.emplace_back(uv.x, uv.y);  // assimp flips glTF's v, which grows downwards
    }
    return place->second;
  }

  const std::string& path_;
  const aiScene& scene_;
  unsigned uv_set_;
  std::map<Vertex, std::uint32_t> vertices_;  // vertices of the current object
  std::set<std::string> names_;
};

}  // namespace

std::vector<ObjectMesh> import_object_meshes(const std::string& path, int uv_set) {
  if (uv_set < 0 || uv_set >= AI_MAX_NUMBER_OF_TEXTURECOORDS)
    refuse_file(path, fmt::format("texture coordinate set is {}, expected 0 to {}", uv_set,
                                  AI_MAX_NUMBER_OF_TEXTURECOORDS - 1));
  const MeshImport import(path, kObjectMeshSteps);
  ObjectReader reader(path, import.scene(), uv_set);
  if (import.scene().mRootNode != nullptr) reader.read(*import.scene().mRootNode, glm::dmat4(1.0));
  if (reader.objects.empty()) refuse_file(path, "holds no triangles");
  return std::move(reader.objects);
}

}  // namespace multum
