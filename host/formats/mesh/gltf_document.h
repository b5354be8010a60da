// SPDX-License-Identifier: Apache-2.0
// A glTF or GLB file's JSON and bytes, for what assimp does not hand on.
#pragma once

#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

namespace multum {

struct GltfDocument {
  std::string path;
  nlohmann::json json;  // an object
  std::string binary;   // of a GLB: what follows the JSON
};

bool is_gltf_name(const std::string& path);  // *.gltf, *.glb

/// A GLB states its length in 32 bits; the buffers of a .glTF are held to the same.
constexpr std::uint64_t kModelBytesMax = (std::uint64_t{1} << 32) - 1;

/// Throws Error(kInput) naming the file: unreadable, not a regular file, 4 GiB or more.
std::string read_model_file(const std::string& path);

/// Throws Error(kInput) naming the file: unreadable, damaged, NUL in its texts, an index beyond its array.
GltfDocument read_gltf_document(const std::string& path);

/// The bytes of a buffer view, wherever they lie: in the GLB, beside the file, in a data URI. Throws Error(kInput).
std::string buffer_view_bytes(const GltfDocument& document, std::size_t view);

/// A base64 data URI's bytes; false where it is none. Throws Error(kInput) for a damaged one.
bool decode_data_uri(const std::string& uri, const std::string& path, std::string& bytes);

/// A relative URI in the file `path` as a path beside that or below, %20 and the like decoded. Throws Error(kInput) for
/// an empty URI, other schemes, NUL, and for what is elsewhere, also behind a link, or is there and not a regular file.
std::string uri_path(const std::string& path, const std::string& uri);

/// The first bytes, up to `byte_max`, of a data URI or of the file at uri_path(), which is opened once: what is checked
/// is what is read. Throws Error(kInput).
std::string uri_bytes(const std::string& path, const std::string& uri, std::uint64_t byte_max);

}  // namespace multum
