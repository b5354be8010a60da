// SPDX-License-Identifier: Apache-2.0
// The objects of a geometry file with mapped texture coordinates, ready for drawing.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/fields/inferred/texture_mapping.h"
#include "host/formats/mesh/object_mesh.h"
#include "runtime_gl/gl/mesh.h"
#include "runtime_gl/probe/placed_mesh.h"

namespace multum {

/// Returns three vertices per triangle, because a vertex at a cut has two pairs of texture coordinates.
gl::MeshData mapped_mesh_data(const ObjectMesh& mesh, const TextureMapping& mapping);

/// Returns the SHA-256 hash of the drawn data, which consists of positions, texture coordinates and their order.
std::string mesh_data_hash(const gl::MeshData& data);

/// Returns the product in single precision for GL. It is computed in double precision, so that every program rounds it
/// in the same way.
glm::mat4 object_to_clip(const glm::dmat4& world_to_clip, const glm::dmat4& object_to_world);

/// If no object has this name, throws Error(kInput) that names `path` and lists the existing objects.
std::size_t find_object(const std::vector<ObjectMesh>& meshes, const std::string& name, const std::string& path);

}  // namespace multum
