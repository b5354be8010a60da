// SPDX-License-Identifier: Apache-2.0
#include "host/formats/mesh/mesh_messages.h"

#include <cmath>
#include <cstring>
#include <type_traits>

#include <fmt/format.h>

#include "host/formats/mesh/finite_vector.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

template <typename Meshes>
constexpr bool is_whole = std::is_same_v<std::remove_const_t<Meshes>, TriangleMesh>;

// Visits the arrays in the order in which they are in messages and in memory.
template <typename Meshes, typename Action>
void for_each_array(Meshes& meshes, const Action& action) {
  if constexpr (is_whole<Meshes>) {
    action(meshes.positions), action(meshes.normals), action(meshes.tangents), action(meshes.uvs);
    action(meshes.indices);
  } else {
    for (auto& mesh : meshes) action(mesh.positions), action(mesh.uvs), action(mesh.indices);
  }
}

template <typename Element>
std::size_t bytes_of(const std::vector<Element>& array) {
  static_assert(std::is_trivially_copyable_v<Element>);
  return array.size() * sizeof(Element);
}

void write(MessageWriter& out, const TriangleMesh& mesh) {
  out.number(std::uint64_t{mesh.parts.size()});
  for (const MeshPart& part : mesh.parts)
    out.text(part.material).number(part.material_index).number(part.first_index).number(part.index_count);
}

void read(MessageReader& in, TriangleMesh& mesh) {
  for (std::size_t left = in.count(); left > 0; --left) {
    MeshPart& part = mesh.parts.emplace_back();
    part.material = in.text();
    part.material_index = in.number<int>();
    part.first_index = in.number<std::uint32_t>();
    part.index_count = in.number<std::uint32_t>();
  }
}

template <typename Matrix, typename Action>
void for_each_entry(Matrix& matrix, const Action& action) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) action(matrix[column][row]);
}

void write(MessageWriter& out, const ObjectMeshes& meshes) {
  out.number(std::uint64_t{meshes.size()});
  for (const ObjectMesh& mesh : meshes) {
    out.text(mesh.name);
    for_each_entry(mesh.object_to_world, [&](double entry) { out.number(entry); });
  }
}

void read(MessageReader& in, ObjectMeshes& meshes) {
  for (std::size_t left = in.count(); left > 0; --left) {
    ObjectMesh& mesh = meshes.emplace_back();
    mesh.name = in.text();
    for_each_entry(mesh.object_to_world, [&](double& entry) { entry = in.number<double>(); });
  }
}

// Returns whether a mesh of either kind can be drawn.
template <typename Mesh>
bool is_sound(const Mesh& mesh) {
  if (mesh.uvs.size() != mesh.positions.size() || mesh.indices.size() % 3 != 0) return false;
  for (const std::uint32_t index : mesh.indices)
    if (index >= mesh.positions.size()) return false;
  for (const glm::vec3& position : mesh.positions)
    if (!is_finite(position)) return false;
  for (const glm::vec2& uv : mesh.uvs)
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return false;
  return true;
}

bool are_sound(const TriangleMesh& mesh) {
  for (const MeshPart& part : mesh.parts)
    if (std::uint64_t{part.first_index} + part.index_count > mesh.indices.size()) return false;
  return mesh.normals.size() == mesh.positions.size() && mesh.tangents.size() == mesh.positions.size() &&
         is_sound(mesh);
}

bool are_sound(const ObjectMeshes& meshes) {
  for (const ObjectMesh& mesh : meshes)
    if (!is_sound(mesh)) return false;
  return true;
}

}  // namespace

std::string open_mesh_request(DecodingRequest kind, const std::string& path, int uv_set) {
  return MessageWriter().number(kind).text(path).number(uv_set).take();
}

std::string read_mesh_request() { return MessageWriter().number(DecodingRequest::kReadMesh).take(); }

template <typename Meshes>
Meshes parse_mesh_answer(const AskedFile& file, MessageReader& in) {
  Meshes meshes;
  read(in, meshes);
  std::uint64_t left = file.memory_max;
  for_each_array(meshes, [&](auto& array) {
    const auto count = in.number<std::uint64_t>();
    if (count > left / sizeof(array[0]))
      refuse_file(file.path,
                  fmt::format("damaged: {} values for vertices or triangles, expected a mesh of at most {} bytes",
                              count, file.memory_max));
    left -= count * sizeof(array[0]);
    array.resize(count);
  });
  return meshes;
}

template <typename Meshes>
std::size_t array_bytes(const Meshes& meshes) {
  std::size_t bytes = 0;
  for_each_array(meshes, [&](const auto& array) { bytes += bytes_of(array); });
  return bytes;
}

template <typename Meshes>
std::string open_mesh_answer(const Meshes& meshes) {
  MessageWriter out;
  out.number(DecodingAnswer::kDone);
  write(out, meshes);
  for_each_array(meshes, [&](const auto& array) { out.number(std::uint64_t{array.size()}); });
  return out.take();
}

template <typename Meshes>
void put_arrays(const Meshes& meshes, std::byte* memory, std::size_t byte_count) {
  MULTUM_CHECK(array_bytes(meshes) <= byte_count);
  for_each_array(meshes, [&](const auto& array) {
    if (!array.empty()) std::memcpy(memory, array.data(), bytes_of(array));
    memory += bytes_of(array);
  });
}

template <typename Meshes>
void take_arrays(const AskedFile& file, const std::byte* memory, Meshes& meshes) {
  for_each_array(meshes, [&](auto& array) {
    if (!array.empty()) std::memcpy(array.data(), memory, bytes_of(array));
    memory += bytes_of(array);
  });
  if (!are_sound(meshes))
    refuse_file(file.path,
                "damaged: decoding did not return a valid mesh, expected a file that can be read by " + file.library);
}

template TriangleMesh parse_mesh_answer(const AskedFile&, MessageReader&);
template ObjectMeshes parse_mesh_answer(const AskedFile&, MessageReader&);
template std::string open_mesh_answer(const TriangleMesh&);
template std::string open_mesh_answer(const ObjectMeshes&);
template void put_arrays(const TriangleMesh&, std::byte*, std::size_t);
template void put_arrays(const ObjectMeshes&, std::byte*, std::size_t);
template std::size_t array_bytes(const TriangleMesh&);
template std::size_t array_bytes(const ObjectMeshes&);
template void take_arrays(const AskedFile&, const std::byte*, TriangleMesh&);
template void take_arrays(const AskedFile&, const std::byte*, ObjectMeshes&);

}  // namespace multum
