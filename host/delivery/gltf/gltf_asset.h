// SPDX-License-Identifier: Apache-2.0
// Reads a glTF 2.0 or GLB file with all its contents and referenced files, for programs that write the file again. JSON
// keys keep their order. Damaged files and references out of range are rejected. Then the bytes of buffers and images
// are loaded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace multum {

/// Keeps the order of keys.
using GltfJson = nlohmann::ordered_json;

struct GltfAsset {
  std::string path;
  GltfJson json;  // a JSON object
  // The bytes of each buffer, as many as the file declares. A buffer that has no bytes in the file is unset, because an
  // extension fills it (fallback buffers of EXT_meshopt_compression).
  std::vector<std::optional<std::string>> buffers;
  std::string other_chunks;  // whole chunks of a GLB that follow its bytes, unchanged

  /// Throws Error(kInput) that names the file.
  [[noreturn]] void refuse(const std::string& what) const;
  /// Returns a top-level array such as "materials", or an empty array if the file has no such array. All elements are
  /// objects.
  const GltfJson& array(const char* name) const;
  /// Returns the index object[key], which is below the length of array(name). Throws Error(kInput).
  std::size_t index(const GltfJson& object, const char* key, const char* name) const;
  /// Returns the bytes of a buffer view. The view must have bytes.
  std::string_view view_bytes(std::size_t view) const;
};

/// The limits of the JSON for text bytes, number of values and depth. They allow all practical models, but ensure that
/// a small malicious file can use at most a few gigabytes of memory.
constexpr std::size_t kGltfJsonBytesMax = std::size_t{64} << 20;
constexpr std::size_t kGltfValuesMax = 8'000'000;
constexpr int kGltfDepthMax = 64;

/// Reads .glb as GLB and every other file as JSON. Checks the file's frame and every buffer, buffer view, image and
/// index. Throws Error(kInput) if the file is unreadable, damaged or of another version, if a text contains NUL, or if
/// a referenced file is not a regular file in the same folder or below.
GltfAsset read_gltf_asset(const std::string& path);

/// The bytes of an image, and whether they are outside the file's buffers, that is, in a separate file or a data URI.
struct GltfImageBytes {
  std::string bytes;
  bool is_outside = false;
};
GltfImageBytes read_gltf_image(const GltfAsset& asset, std::size_t image);

/// Returns a type such as "image/png", detected from the bytes. Returns an empty string for types that neither glTF nor
/// its extensions support.
std::string gltf_image_type(std::string_view bytes);

/// Returns the non-negative integer of a key, or nullopt if the key has no such value.
std::optional<std::uint64_t> unsigned_at(const GltfJson& object, const char* key);

}  // namespace multum
