// SPDX-License-Identifier: Apache-2.0
// The objects of a scene file by their names, each in its own space: what a ray-traced animation is made of.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace multum {

struct ObjectMesh {
  std::string name;                    // of the glTF node or the OBJ object
  std::vector<glm::vec3> positions;    // object space
  std::vector<glm::vec2> uvs;          // the texture coordinate set asked for; v grows upwards in the image
  std::vector<std::uint32_t> indices;  // three a triangle
  glm::dmat4 object_to_world{1.0};     // as the file places it; an OBJ's is the identity
};

/// Where the object is: as `moved` says by its name, else as its file does.
const glm::dmat4& object_place(const ObjectMesh& mesh, const std::map<std::string, glm::dmat4>& moved);

/// Every object with triangles, in the file's order; meshes of one node are one object. `uv_set`: 0 is TEXCOORD_0.
/// Throws Error(kInput) naming the file, the object and what is wrong: no texture coordinates of that set, indices out
/// of range, values that are not finite, two objects of one name.
std::vector<ObjectMesh> read_object_meshes(const std::string& path, int uv_set);

}  // namespace multum
