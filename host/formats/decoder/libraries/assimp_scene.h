// SPDX-License-Identifier: Apache-2.0
// Imports a scene with assimp for every reader of meshes. Watches the warnings of the library, and checks its numbers.
#pragma once

#include <memory>
#include <string>

#include <assimp/vector3.h>
#include <glm/vec3.hpp>

#include "host/formats/mesh/finite_vector.h"
#include "host/foundation/base/error.h"

struct aiScene;
namespace Assimp {
class Importer;
}

namespace multum {

/// A file as imported by assimp.
class MeshImport {
 public:
  /// `steps` are aiProcess_ flags. Throws Error(kInput), which names the file, if check_gltf_file() rejects it, assimp
  /// cannot read it, or indices are out of range.
  MeshImport(const std::string& path, unsigned steps);
  ~MeshImport();
  MeshImport(const MeshImport&) = delete;
  MeshImport& operator=(const MeshImport&) = delete;
  const aiScene& scene() const { return *scene_; }

 private:
  std::unique_ptr<Assimp::Importer> importer_;  // owns the scene
  const aiScene* scene_;
};

inline glm::vec3 to_vec3(const aiVector3D& v) { return {v.x, v.y, v.z}; }

}  // namespace multum
