// SPDX-License-Identifier: Apache-2.0
// Limits of a child (host/foundation/sandbox/decoding_child.h). One corner of a triangle takes 20 bytes in an OBJ file,
// but about a kilobyte in memory: assimp's vertex, its copy for a placed node, our vertex, and an entry in the table
// that joins vertices.
//   memory   memory_base + 64 times the size of the file and of a glTF file's buffers
//   time     time_base + 1 s per MiB of these files
#include "host/formats/mesh/mesh_source.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "host/formats/mesh/gltf_document.h"
#include "host/formats/mesh/mesh.h"
#include "host/formats/mesh/mesh_messages.h"
#include "host/formats/mesh/object_mesh.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {
namespace {

DecodingChild& mesh_child() {
  static DecodingChild child;
  return child;
}

std::uint64_t file_bytes(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  return error ? 0 : size;
}

// Ignores faults of the file, because its reader reports them.
std::uint64_t buffer_bytes(const std::string& path) {
  std::uint64_t bytes = 0;
  try {
    const GltfDocument document = read_gltf_document(path);
    for (const nlohmann::json& buffer : document.json.value("buffers", nlohmann::json::array())) {
      const auto length = buffer.find("byteLength");
      if (length == buffer.end() || !length->is_number_unsigned()) continue;
      if (const std::string uri = buffer.value("uri", ""); !uri.empty() && !uri.starts_with("data:"))
        bytes += std::min(file_bytes(uri_path(document.path, uri)), length->get<std::uint64_t>());
    }
  } catch (const Error&) {
  } catch (const nlohmann::json::exception&) {
  }
  return bytes;
}

template <typename Meshes>
Meshes read_in_child(DecodingRequest kind, const std::string& path, int uv_set) {
  constexpr std::uint64_t kMemoryTimes = 64, kBytesASecond = std::uint64_t{1} << 20;
  open_regular_file(path);  // rejects irregular files without a child; the child reports a missing file
  DecodedFile file(mesh_child(), path, "assimp");
  const std::uint64_t bytes = file_bytes(path) + (is_gltf_name(path) ? buffer_bytes(path) : 0);
  file.allow(kMemoryTimes * bytes, std::chrono::seconds(bytes / kBytesASecond));
  auto meshes = file.ask(open_mesh_request(kind, std::filesystem::absolute(path).string(), uv_set),
                         [&](MessageReader& in) { return parse_mesh_answer<Meshes>(file.asked(), in); });
  const std::byte* const memory = file.memory().reserve(array_bytes(meshes));
  file.ask(read_mesh_request(), [](MessageReader&) { return true; });
  take_arrays(file.asked(), memory, meshes);
  return meshes;
}

}  // namespace

void set_mesh_child(DecodingChild child) { mesh_child() = std::move(child); }

TriangleMesh read_mesh(const std::string& path, int uv_set) {
  return read_in_child<TriangleMesh>(DecodingRequest::kOpenMesh, path, uv_set);
}

std::vector<ObjectMesh> read_object_meshes(const std::string& path, int uv_set) {
  return read_in_child<ObjectMeshes>(DecodingRequest::kOpenObjects, path, uv_set);
}

}  // namespace multum
