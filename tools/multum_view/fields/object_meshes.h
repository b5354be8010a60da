// SPDX-License-Identifier: Apache-2.0
// The objects of a geometry file with mapped texture coordinates, ready to be drawn.
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

/// Vertices three a triangle: a cut may give a vertex two coordinates.
gl::MeshData mapped_mesh_data(const ObjectMesh& mesh, const TextureMapping& mapping);

/// SHA-256 of what is drawn: positions, coordinates, order.
std::string mesh_data_hash(const gl::MeshData& data);

/// In single precision, as the GL gets it: multiplied in double, so that every program rounds alike.
glm::mat4 object_to_clip(const glm::dmat4& world_to_clip, const glm::dmat4& object_to_world);

/// Throws Error(kInput) naming `path` when there is no such object, listing those there are.
std::size_t find_object(const std::vector<ObjectMesh>& meshes, const std::string& name, const std::string& path);

}  // namespace multum
