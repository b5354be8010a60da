// SPDX-License-Identifier: Apache-2.0
// Messages between a process and its decoder of meshes (host/formats/decoder/mesh_decoder.h).
//
//   request   kOpenMesh, path, uv_set      answer   counts, parts
//             kOpenObjects, path, uv_set            of each object: counts, name, place
//             kReadMesh                             nothing; its arrays lie in the shared memory, one after the other
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

/// Of `Meshes`, TriangleMesh or ObjectMeshes, all but what its arrays hold; they are as long as they will be. Throws
/// Error(kInput) naming the file where that is more than the child was held to.
template <typename Meshes>
Meshes parse_mesh_answer(const AskedFile& file, MessageReader& in);

/// Of all its arrays together.
template <typename Meshes>
std::size_t array_bytes(const Meshes& meshes);

/// Throws Error(kInput) naming the file where they are of no mesh: what follows computes with their numbers.
template <typename Meshes>
void take_arrays(const AskedFile& file, const std::byte* memory, Meshes& meshes);

/// The child's side: its answer to a request to open, and its arrays put where the other side takes them from.
template <typename Meshes>
std::string open_mesh_answer(const Meshes& meshes);
template <typename Meshes>
void put_arrays(const Meshes& meshes, std::byte* memory, std::size_t byte_count);

}  // namespace multum
