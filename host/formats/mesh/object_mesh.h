// SPDX-License-Identifier: Apache-2.0
// Objects of a scene file by name, for ray-traced animations. Each object has its own space.
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
  std::string name;                    // name of the glTF node or the OBJ object
  std::vector<glm::vec3> positions;    // positions in object space
  std::vector<glm::vec2> uvs;          // from the requested texture coordinate set; v grows upwards in the image
  std::vector<std::uint32_t> indices;  // three per triangle
  glm::dmat4 object_to_world{1.0};     // transform from the file; the identity for OBJ
};

/// Returns the transform of the object. If `moved` has the name of the object, the transform comes from `moved`.
/// Otherwise it comes from the file.
const glm::dmat4& object_place(const ObjectMesh& mesh, const std::map<std::string, glm::dmat4>& moved);

/// Reads every object that has triangles, in the order of the file. All meshes of one node are one object. `uv_set` 0
/// is TEXCOORD_0. Throws Error(kInput), which names the file, the object and the fault. The faults are missing texture
/// coordinates of that set, indices out of range, values that are not finite, and two objects with the same name.
std::vector<ObjectMesh> read_object_meshes(const std::string& path, int uv_set);

}  // namespace multum
