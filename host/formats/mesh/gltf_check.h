// SPDX-License-Identifier: Apache-2.0
// Checks what a glTF file requires before assimp reads it: assimp ignores required extensions that it does not know and
// hands on an empty or wrong mesh.
#pragma once

#include <string>

namespace multum {

/// Does nothing for other file types. Throws Error(kInput) naming the file: unreadable, damaged, buffers in files that
/// are elsewhere, or requiring an
/// extension that changes geometry and cannot be read, by its name (KHR_draco_mesh_compression, ...).
void check_gltf_file(const std::string& path);

}  // namespace multum
