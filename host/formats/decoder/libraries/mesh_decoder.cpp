// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/libraries/mesh_decoder.h"

#include "host/formats/decoder/libraries/mesh_readers.h"
#include "host/foundation/sandbox/damaged_file.h"

namespace multum {

std::string MeshDecoder::answer(std::string_view request, SharedMemory& memory) {
  MessageReader in(request);
  const DecodingRequest kind{in.number<std::uint8_t>()};
  if (kind == DecodingRequest::kReadMesh) {
    std::size_t byte_count = 0;
    std::byte* const data = memory.see(byte_count);
    std::visit([&](const auto& meshes) { put_arrays(meshes, data, byte_count); }, meshes_);
    close();
    return MessageWriter().number(DecodingAnswer::kDone).take();
  }
  close();
  const std::string path = in.text();
  const int uv_set = in.number<int>();
  with_damage_named(path, [&] {
    if (kind == DecodingRequest::kOpenMesh) meshes_ = import_mesh(path, uv_set);
    else meshes_ = import_object_meshes(path, uv_set);
  });
  return std::visit([](const auto& meshes) { return open_mesh_answer(meshes); }, meshes_);
}

}  // namespace multum
