// SPDX-License-Identifier: Apache-2.0
// A glTF or GLB file's JSON and bytes, for what assimp does not hand on.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace multum {

struct GltfDocument {
  std::string path;
  nlohmann::json json;  // an object
  std::string binary;   // of a GLB: what follows the JSON
};

bool is_gltf_name(const std::string& path);  // *.gltf, *.glb

/// Throws Error(kInput) naming the file: unreadable, damaged.
GltfDocument read_gltf_document(const std::string& path);

/// The bytes of a buffer view, wherever they lie: in the GLB, beside the file, in a data URI. Throws Error(kInput).
std::string buffer_view_bytes(const GltfDocument& document, std::size_t view);

/// A base64 data URI's bytes; false where it is none. Throws Error(kInput) for a damaged one.
bool decode_data_uri(const std::string& uri, const std::string& path, std::string& bytes);

/// A relative URI in the file `path` as a path beside that or below, %20 and the like decoded. Throws Error(kInput) for
/// other schemes, and for what is elsewhere.
std::string uri_path(const std::string& path, const std::string& uri);

}  // namespace multum
