// SPDX-License-Identifier: Apache-2.0
// Where meshes are read: in this process, or in a child, since assimp dies on some files or takes minutes and
// gigabytes. Either way a file reads the same, and is refused in the same words.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/base/decoding_child.h"
#include "host/mesh/mesh.h"
#include "host/mesh/object_mesh.h"

namespace multum {

/// For the whole process; none: in this one, as it is unless a program says otherwise at its start.
void set_mesh_child(std::optional<DecodingChild> child);

/// As read_mesh() and read_object_meshes(), in this process.
TriangleMesh read_mesh_here(const std::string& path, int uv_set);
std::vector<ObjectMesh> read_object_meshes_here(const std::string& path, int uv_set);

}  // namespace multum
