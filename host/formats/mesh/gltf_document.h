// SPDX-License-Identifier: Apache-2.0
// Reads the JSON and the bytes of a glTF or GLB file that assimp does not return.
#pragma once

#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

namespace multum {

struct GltfDocument {
  std::string path;
  nlohmann::json json;  // a JSON object
  std::string binary;   // for a GLB: the bytes after the JSON
};

/// Returns the extension of a name in lower case and without the dot, or an empty string if there is none.
std::string lower_extension(const std::string& path);
bool is_gltf_name(const std::string& path);  // *.gltf, *.glb

/// The limit of file sizes. A GLB stores its length in 32 bits, and the buffers of a .gltf have the same limit.
constexpr std::uint64_t kModelBytesMax = (std::uint64_t{1} << 32) - 1;

/// Reads a whole model file. Throws Error(kInput), which names the file, if it is unreadable, not a regular file, or
/// has 4 GiB or more.
std::string read_model_file(const std::string& path);

/// Reads a glTF file. Throws Error(kInput), which names the file, if it is unreadable or damaged, has NUL in a string,
/// or has an index beyond its array.
GltfDocument read_gltf_document(const std::string& path);

/// Returns the bytes of a buffer view. They are in the GLB, in a file next to it, or in a data URI. Throws
/// Error(kInput).
std::string buffer_view_bytes(const GltfDocument& document, std::size_t view);

/// Decodes a base64 data URI. Returns false for other URIs. Throws Error(kInput) for a damaged base64 data URI.
bool decode_data_uri(const std::string& uri, const std::string& path, std::string& bytes);

/// Resolves a relative URI in the file `path` to a path in the folder of that file or below, and decodes %20 and the
/// like. Throws Error(kInput) for an empty URI, other schemes, NUL, a place outside the folder (also if a link leads
/// there), or an existing file that is not regular.
std::string uri_path(const std::string& path, const std::string& uri);

/// Returns the first bytes, at most `byte_max`, of a data URI or of the file at uri_path(). The file is opened only
/// once, so the checks apply to the bytes that are read. Throws Error(kInput).
std::string uri_bytes(const std::string& path, const std::string& uri, std::uint64_t byte_max);

}  // namespace multum
