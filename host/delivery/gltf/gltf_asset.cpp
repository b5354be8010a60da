// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/gltf_asset.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host/formats/mesh/gltf_document.h"
#include "host/formats/mesh/gltf_indices.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

// A GLB has a header of 12 bytes ("glTF", version, length), then chunks of (length, type, data).
constexpr std::size_t kGlbHeader = 12, kChunkHeader = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i > 0; --i) value = (value << 8) | static_cast<unsigned char>(bytes[at + i - 1]);
  return value;
}

struct GlbParts {
  std::string_view json;
  std::optional<std::string_view> binary;
  std::string_view others;
};

GlbParts split_chunks(std::string_view bytes, const std::string& path) {
  if (bytes.substr(0, 4) != "glTF") refuse_file(path, "is not a GLB file: it does not begin with glTF");
  if (bytes.size() < kGlbHeader)
    refuse_file(
        path, fmt::format("is a damaged GLB file: it has {} bytes, expected a header of {}", bytes.size(), kGlbHeader));
  if (const std::uint32_t version = number_at(bytes, 4); version != 2)
    refuse_file(path, fmt::format("is a GLB file of version {}, expected 2", version));
  if (const std::uint32_t length = number_at(bytes, 8); length != bytes.size())
    refuse_file(path, fmt::format("is a damaged GLB file: its header states {} bytes, but the file has {}", length,
                                  bytes.size()));
  GlbParts parts;
  std::size_t at = kGlbHeader;
  for (int chunk = 0; at < bytes.size(); ++chunk) {
    const std::size_t left = bytes.size() - at;
    const std::size_t length = left < kChunkHeader ? 0 : number_at(bytes, at);
    if (left < kChunkHeader || length > left - kChunkHeader)
      refuse_file(path, fmt::format("is a damaged GLB file: its chunk {} of {} bytes is incomplete", chunk, length));
    const std::uint32_t type = number_at(bytes, at + 4);
    const std::string_view data = bytes.substr(at + kChunkHeader, length);
    if ((chunk == 0) != (type == kJsonChunk))
      refuse_file(path, "is a damaged GLB file: expected JSON in the first chunk only");
    if (chunk == 0) parts.json = data;
    else if (chunk == 1 && type == kBinaryChunk) parts.binary = data;
    else parts.others = bytes.substr(at);
    if (!parts.others.empty()) break;
    at += kChunkHeader + length;
  }
  if (parts.json.data() == nullptr) refuse_file(path, "is a damaged GLB file: it has no JSON");
  return parts;
}

GltfJson parse_gltf_json(std::string_view text, const std::string& path) {
  if (text.size() > kGltfJsonBytesMax)
    refuse_file(path, fmt::format("has {} bytes of JSON, expected at most {}", text.size(), kGltfJsonBytesMax));
  refuse_nul(text, path);
  std::size_t count = 0;
  const auto check = [&](int depth, nlohmann::detail::parse_event_t, GltfJson&) {
    if (depth > kGltfDepthMax)
      refuse_file(path, fmt::format("nests its JSON deeper than the limit of {} levels", kGltfDepthMax));
    if (++count > kGltfValuesMax)
      refuse_file(path, fmt::format("has more than {} values in its JSON, which is the limit", kGltfValuesMax));
    return true;
  };
  try {
    GltfJson json = GltfJson::parse(text, check);
    if (!json.is_object()) refuse_file(path, "is damaged: its JSON is not an object");
    return json;
  } catch (const GltfJson::parse_error& error) {
    refuse_file(path, fmt::format("is damaged: its JSON cannot be parsed at byte {}", error.byte));
  }
}

// Returns the bytes to which a URI refers, up to a given number. The bytes are embedded in the URI or stored in a file.
std::string bytes_of_uri(const GltfAsset& asset, const GltfJson& uri, const std::string& what, std::uint64_t byte_max) {
  if (!uri.is_string()) asset.refuse(what + " has a URI that is not a string");
  return uri_bytes(asset.path, uri.get_ref<const std::string&>(), byte_max);
}

void read_buffers(GltfAsset& asset, bool is_glb, std::optional<std::string_view> binary) {
  for (const GltfJson& buffer : asset.array("buffers")) {
    const std::string what = fmt::format("buffer {}", asset.buffers.size());
    const auto length = unsigned_at(buffer, "byteLength");
    if (!length) asset.refuse(what + " has no byteLength");
    if (*length > kModelBytesMax)
      asset.refuse(fmt::format("{} declares {} bytes, expected less than 4 GiB", what, *length));
    std::optional<std::string> bytes;
    if (buffer.contains("uri")) bytes = bytes_of_uri(asset, buffer.at("uri"), what, *length);
    else if (is_glb && asset.buffers.empty() && binary) bytes = std::string(*binary);
    else if (!buffer.contains("extensions")) asset.refuse(what + " has neither a URI nor bytes in the file");
    if (bytes && bytes->size() < *length)
      asset.refuse(fmt::format("{} declares {} bytes, found {}", what, *length, bytes->size()));
    if (bytes) bytes->resize(*length);
    asset.buffers.push_back(std::move(bytes));
  }
}

void check_views(const GltfAsset& asset) {
  std::size_t number = 0;
  for (const GltfJson& view : asset.array("bufferViews")) {
    const std::string what = fmt::format("buffer view {}", number++);
    const GltfJson& buffer = asset.array("buffers").at(asset.index(view, "buffer", "buffers"));
    const auto length = unsigned_at(view, "byteLength");
    const std::uint64_t offset = unsigned_at(view, "byteOffset").value_or(0), all = *unsigned_at(buffer, "byteLength");
    if (!length || (view.contains("byteOffset") && !unsigned_at(view, "byteOffset")))
      asset.refuse(what + " has a byteOffset or byteLength that is not a valid number of bytes");
    if (offset > all || *length > all - offset)
      asset.refuse(
          fmt::format("{} refers to bytes {} to {} of a buffer of {} bytes", what, offset, offset + *length, all));
  }
}

void check_images(const GltfAsset& asset) {
  std::size_t number = 0;
  for (const GltfJson& image : asset.array("images")) {
    const std::string what = fmt::format("image {}", number++);
    if (image.contains("bufferView")) {
      const std::size_t view = asset.index(image, "bufferView", "bufferViews");
      if (!asset.buffers[asset.index(asset.array("bufferViews").at(view), "buffer", "buffers")])
        asset.refuse(what + " is in a buffer that has no bytes in the file");
    } else if (!image.contains("uri") || !image.at("uri").is_string()) {
      asset.refuse(what + " has neither a URI nor a buffer view");
    } else if (const auto& uri = image.at("uri").get_ref<const std::string&>(); !uri.starts_with("data:")) {
      uri_path(asset.path, uri);
    }
  }
}

}  // namespace

void GltfAsset::refuse(const std::string& what) const { refuse_file(path, what); }

const GltfJson& GltfAsset::array(const char* name) const {
  static const GltfJson kNone = GltfJson::array();
  const auto found = json.find(name);
  return found == json.end() ? kNone : *found;
}

std::size_t GltfAsset::index(const GltfJson& object, const char* key, const char* name) const {
  const auto found = unsigned_at(object, key);
  const std::size_t count = array(name).size();
  if (!found || *found >= count)
    refuse(fmt::format("{} is {}, expected a number below {}, the length of {}", key,
                       object.contains(key) ? json_text(object.at(key)).substr(0, 40) : "missing", count, name));
  return static_cast<std::size_t>(*found);
}

std::string_view GltfAsset::view_bytes(std::size_t view) const {
  const GltfJson& object = array("bufferViews").at(view);
  const std::optional<std::string>& buffer = buffers[index(object, "buffer", "buffers")];
  MULTUM_CHECK(buffer.has_value());
  return std::string_view(*buffer).substr(unsigned_at(object, "byteOffset").value_or(0),
                                          *unsigned_at(object, "byteLength"));
}

GltfAsset read_gltf_asset(const std::string& path) {
  if (!is_gltf_name(path)) refuse_file(path, "expected a glTF file, *.gltf or *.glb");
  const std::string bytes = read_model_file(path);
  const bool is_glb = bytes.starts_with("glTF") || path.ends_with(".glb");
  GlbParts parts;
  if (is_glb) parts = split_chunks(bytes, path);
  else parts.json = bytes;
  GltfAsset asset;
  asset.path = path;
  asset.json = parse_gltf_json(parts.json, path);
  asset.other_chunks = std::string(parts.others);
  for (const char* name : {"accessors", "animations", "buffers", "bufferViews", "images", "materials", "meshes",
                           "nodes", "samplers", "scenes", "skins", "textures"}) {
    const GltfJson& all = asset.array(name);
    if (!all.is_array() || !std::all_of(all.begin(), all.end(), [](const GltfJson& one) { return one.is_object(); }))
      asset.refuse(fmt::format("is damaged: {} is not an array of objects", name));
  }
  const auto about = asset.json.find("asset");
  const bool has_version =
      about != asset.json.end() && about->is_object() && about->contains("version") && about->at("version").is_string();
  const std::string version = has_version ? about->at("version").get<std::string>() : "";
  if (!version.starts_with("2."))
    asset.refuse(fmt::format("has glTF version '{}', expected 2.0", version.substr(0, 20)));
  check_gltf_indices(asset.json, path);
  read_buffers(asset, is_glb, parts.binary);
  check_views(asset);
  check_images(asset);
  return asset;
}

GltfImageBytes read_gltf_image(const GltfAsset& asset, std::size_t image) {
  const GltfJson& object = asset.array("images").at(image);
  if (object.contains("bufferView"))
    return {std::string(asset.view_bytes(asset.index(object, "bufferView", "bufferViews"))), false};
  std::string bytes = bytes_of_uri(asset, object.at("uri"), fmt::format("image {}", image), kModelBytesMax + 1);
  if (bytes.size() > kModelBytesMax)
    asset.refuse(fmt::format("image {} has 4 GiB or more, which exceeds the limit of GLB", image));
  return {std::move(bytes), true};
}

std::string gltf_image_type(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return "image/png";
  if (bytes.starts_with("\xff\xd8\xff")) return "image/jpeg";
  if (bytes.starts_with("RIFF") && bytes.substr(8, 4) == "WEBP") return "image/webp";
  if (bytes.starts_with("\xabKTX 20\xbb\r\n\x1a\n")) return "image/ktx2";
  if (bytes.starts_with("DDS ")) return "image/vnd-ms.dds";
  if (bytes.size() >= 12 && bytes.substr(4, 8) == "ftypavif") return "image/avif";
  return "";
}

std::optional<std::uint64_t> unsigned_at(const GltfJson& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_unsigned()) return std::nullopt;
  return found->get<std::uint64_t>();
}

}  // namespace multum
