// SPDX-License-Identifier: Apache-2.0
// Reads a glTF 2.0 or GLB file with all that it holds and names, for programs that write it again: its JSON with every
// key in its place, the bytes of its buffers, and those of its images. What is damaged, or reaches beyond what is
// there, is refused before anything is done with it.
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
  GltfJson json;  // an object
  // Bytes by buffer, as many as it says; none of a buffer that has none in the file: extensions fill it
  // (EXT_meshopt_compression's fallback).
  std::vector<std::optional<std::string>> buffers;
  std::string other_chunks;  // of a GLB, behind its bytes: whole chunks, as they are

  /// Throws Error(kInput) naming the file.
  [[noreturn]] void refuse(const std::string& what) const;
  /// One of the arrays at the top: "materials". Empty where there is none. All its elements are objects.
  const GltfJson& array(const char* name) const;
  /// An index, object[key], below the length of array(name). Throws Error(kInput).
  std::size_t index(const GltfJson& object, const char* key, const char* name) const;
  /// Bytes of a buffer view that has some.
  std::string_view view_bytes(std::size_t view) const;
};

/// Limits of the JSON: of its text, of the values in it and of their depth. They hold models of any use, and keep the
/// memory that a small file can ask for within some gigabytes.
constexpr std::size_t kGltfJsonBytesMax = std::size_t{64} << 20;
constexpr std::size_t kGltfValuesMax = 8'000'000;
constexpr int kGltfDepthMax = 64;

/// A .glb is read as GLB, everything else as JSON. Checks the frame of the file, and every buffer, buffer view and
/// image, and every index. Throws Error(kInput): unreadable, damaged, another version, NUL in a text, a file named that
/// is not a regular one beside it or below.
GltfAsset read_gltf_asset(const std::string& path);

/// An image's bytes, and whether they lie outside the file's buffers: in a file beside it, or a data URI.
struct GltfImageBytes {
  std::string bytes;
  bool is_outside = false;
};
GltfImageBytes read_gltf_image(const GltfAsset& asset, std::size_t image);

/// "image/png" and the like, by what the bytes are; empty: of none of the kinds that glTF and its extensions have.
std::string gltf_image_type(std::string_view bytes);

/// A non-negative integer; nullopt where there is none under this key.
std::optional<std::uint64_t> unsigned_at(const GltfJson& object, const char* key);

}  // namespace multum
