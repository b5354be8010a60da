// SPDX-License-Identifier: Apache-2.0
// Checks the requirements of a glTF file before assimp reads it. assimp ignores required extensions that it does not
// know, and returns an empty or wrong mesh.
#pragma once

#include <string>

namespace multum {

/// Does nothing for other file types. Throws Error(kInput), which names the file, if it is unreadable or damaged, or if
/// its buffers are outside its folder. Also rejects a required extension that changes geometry and cannot be read. The
/// message names this extension (KHR_draco_mesh_compression, ...).
void check_gltf_file(const std::string& path);

}  // namespace multum
