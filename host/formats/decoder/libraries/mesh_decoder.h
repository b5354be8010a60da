// SPDX-License-Identifier: Apache-2.0
// Decodes meshes in the child process, and answers the requests of host/formats/mesh/mesh_messages.h.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "host/formats/mesh/mesh_messages.h"
#include "host/foundation/sandbox/shared_memory.h"

namespace multum {

/// Decodes one file at a time.
class MeshDecoder {
 public:
  /// Throws Error if the request fails.
  std::string answer(std::string_view request, SharedMemory& memory);
  void close() { meshes_ = {}; }

 private:
  std::variant<TriangleMesh, ObjectMeshes> meshes_;
};

}  // namespace multum
