// SPDX-License-Identifier: Apache-2.0
#include "host/formats/mesh/object_mesh.h"

namespace multum {

const glm::dmat4& object_place(const ObjectMesh& mesh, const std::map<std::string, glm::dmat4>& moved) {
  const auto found = moved.find(mesh.name);
  return found != moved.end() ? found->second : mesh.object_to_world;
}

}  // namespace multum
