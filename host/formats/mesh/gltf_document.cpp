// SPDX-License-Identifier: Apache-2.0
#include "host/formats/mesh/gltf_document.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

#include "host/formats/mesh/gltf_indices.h"
#include "host/foundation/base/base64.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {
namespace {

// Reads at most `byte_max` bytes.
std::string read_from(OpenFile opened, const std::string& path, std::uint64_t byte_max) {
  if (!opened.is_open()) refuse_file(path, std::string("cannot be read: ") + std::strerror(errno));
  RegularFileStream file(std::move(opened));
  file.seekg(0, std::ios::end);
  const auto size = static_cast<std::uint64_t>(std::streamoff(file.tellg()));
  std::string bytes(static_cast<std::size_t>(std::min(size, byte_max)), '\0');
  file.seekg(0);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) refuse_file(path, "cannot be read");
  return bytes;
}

std::string folder_of_model(const std::string& path) { return std::filesystem::path(path).parent_path().string(); }

// Returns the file name that a relative URI stands for.
std::string decoded_uri(const std::string& path, const std::string& uri) {
  if (uri.empty()) refuse_file(path, "refers to a file by an empty URI, expected the name of a file in its folder");
  if (uri.find("://") != std::string::npos) refuse_file(path, "names " + uri + ", expected a file in its folder");
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const bool is_code = uri[i] == '%' && i + 2 < uri.size() &&
                         std::isxdigit(static_cast<unsigned char>(uri[i + 1])) != 0 &&
                         std::isxdigit(static_cast<unsigned char>(uri[i + 2])) != 0;
    name += is_code ? static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16)) : uri[i];
    if (is_code) i += 2;
  }
  if (name.find('\0') != std::string::npos)
    refuse_file(path, "names " + uri + ", which contains a NUL (%00); expected the name of a file in its folder");
  // A model from another person must not be able to include files of this machine.
  const std::filesystem::path relative = std::filesystem::path(name).lexically_normal();
  if (relative.is_absolute() || *relative.begin() == "..")
    refuse_file(path, "names " + name + ", which is not in its folder; expected a file in its folder or below");
  return (std::filesystem::path(path).parent_path() / relative).string();
}

std::uint32_t little_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i > 0; --i) value = (value << 8) | static_cast<unsigned char>(bytes[at + i - 1]);
  return value;
}

// Splits a GLB file. The header of a GLB has 12 bytes ("glTF", version, length). Chunks of (length, type, data) follow.
// The first chunk is JSON, and the optional second chunk holds bytes.
void split_glb(const std::string& bytes, const std::string& path, std::string& json, std::string& binary) {
  constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
  if (bytes.compare(0, 4, "glTF") != 0) refuse_file(path, "is not a GLB file: it does not begin with glTF");
  if (bytes.size() < 20)
    refuse_file(path, "is a damaged GLB file: it has " + std::to_string(bytes.size()) +
                          " bytes, expected at least 20 for the header and the first chunk");
  const std::size_t length = little_endian(bytes, 12);
  if (little_endian(bytes, 16) != kJsonChunk || length > bytes.size() - 20)
    refuse_file(path, "is a damaged GLB file: its JSON chunk of " + std::to_string(length) + " bytes is incomplete");
  json = bytes.substr(20, length);
  const std::size_t next = 20 + length;
  if (next + 8 > bytes.size()) return;
  const std::size_t binary_length = little_endian(bytes, next);
  if (binary_length > bytes.size() - next - 8)
    refuse_file(path, "is a damaged GLB file: its chunk of " + std::to_string(binary_length) + " bytes is incomplete");
  binary = bytes.substr(next + 8, binary_length);
}

}  // namespace

std::string lower_extension(const std::string& path) {
  const std::size_t dot = path.find_last_of('.');
  std::string extension = dot == std::string::npos ? "" : path.substr(dot + 1);
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_gltf_name(const std::string& path) {
  const std::string extension = lower_extension(path);
  return extension == "gltf" || extension == "glb";
}

GltfDocument read_gltf_document(const std::string& path) {
  GltfDocument document{path, {}, ""};
  std::string bytes = read_model_file(path), json;
  if (lower_extension(path) == "glb") split_glb(bytes, path, json, document.binary);
  else json = std::move(bytes);
  refuse_nul(json, path);
  document.json = nlohmann::json::parse(json, nullptr, false);
  if (!document.json.is_object()) refuse_file(path, "is damaged: its glTF JSON cannot be parsed");
  check_gltf_indices(document.json, path);
  return document;
}

bool decode_data_uri(const std::string& uri, const std::string& path, std::string& bytes) {
  if (!uri.starts_with("data:")) return false;
  const std::size_t comma = uri.find(',');
  if (comma == std::string::npos || uri.substr(0, comma).find(";base64") == std::string::npos)
    refuse_file(path, "contains a data URI that is not base64");
  std::optional<std::string> decoded = decode_base64(uri.substr(comma + 1));
  if (!decoded) refuse_file(path, "contains a data URI that is not base64");
  bytes = std::move(*decoded);
  return true;
}

std::string read_model_file(const std::string& path) {
  std::string bytes = read_from(open_regular_file(path), path, kModelBytesMax + 1);
  if (bytes.size() > kModelBytesMax) refuse_file(path, "has 4 GiB or more, which exceeds the limit of GLB");
  return bytes;
}

std::string uri_path(const std::string& path, const std::string& uri) {
  std::string name = decoded_uri(path, uri);
  open_file_beneath(folder_of_model(path), name);
  return name;
}

std::string uri_bytes(const std::string& path, const std::string& uri, std::uint64_t byte_max) {
  std::string bytes;
  if (decode_data_uri(uri, path, bytes)) {
    bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), byte_max)));
    return bytes;
  }
  const std::string name = decoded_uri(path, uri);
  return read_from(open_file_beneath(folder_of_model(path), name), name, byte_max);
}

std::string buffer_view_bytes(const GltfDocument& document, std::size_t view) {
  const std::string what = "buffer view " + std::to_string(view);
  try {
    const nlohmann::json& json = document.json.at("bufferViews").at(view);
    const auto buffer = static_cast<std::size_t>(json_integer(json, "buffer", 0, INT32_MAX));
    constexpr auto kLengthMax = static_cast<std::int64_t>(kModelBytesMax);
    const auto offset =
        static_cast<std::size_t>(json.contains("byteOffset") ? json_integer(json, "byteOffset", 0, kLengthMax) : 0);
    const auto length = static_cast<std::size_t>(json_integer(json, "byteLength", 0, kLengthMax));
    const nlohmann::json& from = document.json.at("buffers").at(buffer);
    const std::string bytes = from.contains("uri")
                                  ? uri_bytes(document.path, from.at("uri").get<std::string>(), offset + length)
                                  : document.binary;
    if (offset > bytes.size() || length > bytes.size() - offset)
      refuse_file(document.path, what + " extends beyond its buffer");
    return bytes.substr(offset, length);
  } catch (const Error& error) {
    if (std::string_view(error.what()).starts_with(document.path)) throw;
    refuse_file(document.path, what + " is damaged: " + error.what());
  } catch (const nlohmann::json::exception&) {
    refuse_file(document.path, what + " is missing or damaged");
  }
}

}  // namespace multum
