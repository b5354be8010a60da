// SPDX-License-Identifier: Apache-2.0
// Reads meshes with assimp in this process (read_mesh(), read_object_meshes()). Used by multum-decode and by tests.
#pragma once

#include <string>
#include <vector>

#include "host/formats/mesh/mesh.h"
#include "host/formats/mesh/object_mesh.h"

namespace multum {

TriangleMesh import_mesh(const std::string& path, int uv_set);
std::vector<ObjectMesh> import_object_meshes(const std::string& path, int uv_set);

}  // namespace multum
