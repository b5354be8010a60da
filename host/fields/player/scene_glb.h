// SPDX-License-Identifier: Apache-2.0
// Writes the objects of a scene file as binary glTF. Only positions, one set of texture coordinates, names and places
// are written.
#pragma once

#include <string>
#include <vector>

#include "host/formats/mesh/object_mesh.h"

namespace multum {

/// Writes a node and a mesh for each object. The texture coordinates become TEXCOORD_`uv_set`.
std::string scene_glb(const std::vector<ObjectMesh>& objects, int uv_set);

}  // namespace multum
