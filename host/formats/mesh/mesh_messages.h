// SPDX-License-Identifier: Apache-2.0
// Messages between a process and its decoder of meshes (host/formats/decoder/libraries/mesh_decoder.h).
//
//   request   kOpenMesh, path, uv_set      answer   counts, parts
//             kOpenObjects, path, uv_set            for each object: counts, name, transform
//             kReadMesh                             nothing; the arrays are in the shared memory, one after another
#pragma once

#include <string>
#include <vector>

#include "host/formats/mesh/mesh.h"
#include "host/formats/mesh/object_mesh.h"
#include "host/foundation/sandbox/decoding_answer.h"

namespace multum {

using ObjectMeshes = std::vector<ObjectMesh>;

std::string open_mesh_request(DecodingRequest kind, const std::string& path, int uv_set);
std::string read_mesh_request();

/// Reads everything except the contents of arrays, which are resized to their final lengths. `Meshes` is TriangleMesh
/// or ObjectMeshes. Throws Error(kInput), which names the file, if the lengths exceed the child's limits.
template <typename Meshes>
Meshes parse_mesh_answer(const AskedFile& file, MessageReader& in);

/// Returns the size of all arrays together.
template <typename Meshes>
std::size_t array_bytes(const Meshes& meshes);

/// Copies the arrays from memory. Throws Error(kInput), which names the file, if the values are not a valid mesh. Later
/// code computes with these values.
template <typename Meshes>
void take_arrays(const AskedFile& file, const std::byte* memory, Meshes& meshes);

/// Does the work of the child. It answers a request to open a file, and copies arrays to memory that the other process
/// reads.
template <typename Meshes>
std::string open_mesh_answer(const Meshes& meshes);
template <typename Meshes>
void put_arrays(const Meshes& meshes, std::byte* memory, std::size_t byte_count);

}  // namespace multum
