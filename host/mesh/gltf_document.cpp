// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/gltf_document.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "host/base/base64.h"
#include "host/base/error.h"

namespace multum {
namespace {

std::string lower_extension(const std::string& path) {
  const std::size_t dot = path.find_last_of('.');
  std::string extension = dot == std::string::npos ? "" : path.substr(dot + 1);
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) refuse_file(path, "cannot be read");
  return text.str();
}

std::uint32_t little_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i > 0; --i) value = (value << 8) | static_cast<unsigned char>(bytes[at + i - 1]);
  return value;
}

// GLB: 12 bytes of header ("glTF", version, length), then chunks of (length, type, data): JSON, then perhaps bytes.
void split_glb(const std::string& bytes, const std::string& path, std::string& json, std::string& binary) {
  constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
  if (bytes.size() < 20 || bytes.compare(0, 4, "glTF") != 0)
    refuse_file(path, "is not a GLB file: it does not begin with glTF");
  const std::size_t length = little_endian(bytes, 12);
  if (little_endian(bytes, 16) != kJsonChunk || length > bytes.size() - 20)
    refuse_file(path, "is a damaged GLB file: its JSON chunk of " + std::to_string(length) + " bytes is not all there");
  json = bytes.substr(20, length);
  const std::size_t next = 20 + length;
  if (next + 8 > bytes.size()) return;
  const std::size_t binary_length = little_endian(bytes, next);
  if (binary_length > bytes.size() - next - 8)
    refuse_file(path,
                "is a damaged GLB file: its chunk of " + std::to_string(binary_length) + " bytes is not all there");
  binary = bytes.substr(next + 8, binary_length);
}

}  // namespace

bool is_gltf_name(const std::string& path) {
  const std::string extension = lower_extension(path);
  return extension == "gltf" || extension == "glb";
}

GltfDocument read_gltf_document(const std::string& path) {
  GltfDocument document{path, {}, ""};
  std::string bytes = read_file(path), json;
  if (lower_extension(path) == "glb") split_glb(bytes, path, json, document.binary);
  else json = std::move(bytes);
  document.json = nlohmann::json::parse(json, nullptr, false);
  if (!document.json.is_object()) refuse_file(path, "is damaged: its glTF JSON cannot be parsed");
  return document;
}

bool decode_data_uri(const std::string& uri, const std::string& path, std::string& bytes) {
  if (!uri.starts_with("data:")) return false;
  const std::size_t comma = uri.find(',');
  if (comma == std::string::npos || uri.substr(0, comma).find(";base64") == std::string::npos)
    refuse_file(path, "holds a data URI that is not base64");
  std::optional<std::string> decoded = decode_base64(uri.substr(comma + 1));
  if (!decoded) refuse_file(path, "holds a data URI that is not base64");
  bytes = std::move(*decoded);
  return true;
}

std::string uri_path(const std::string& path, const std::string& uri) {
  if (uri.find("://") != std::string::npos) refuse_file(path, "names " + uri + ", expected a file beside it");
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const bool is_code = uri[i] == '%' && i + 2 < uri.size() &&
                         std::isxdigit(static_cast<unsigned char>(uri[i + 1])) != 0 &&
                         std::isxdigit(static_cast<unsigned char>(uri[i + 2])) != 0;
    name += is_code ? static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16)) : uri[i];
    if (is_code) i += 2;
  }
  // A model that came from somebody else must not bring in files of this machine.
  const std::filesystem::path relative = std::filesystem::path(name).lexically_normal();
  if (relative.is_absolute() || *relative.begin() == "..")
    refuse_file(path, "names " + name + ", which is not in its folder; expected a file beside it or below");
  return (std::filesystem::path(path).parent_path() / relative).string();
}

std::string buffer_view_bytes(const GltfDocument& document, std::size_t view) {
  const std::string what = "buffer view " + std::to_string(view);
  try {
    const nlohmann::json& json = document.json.at("bufferViews").at(view);
    const auto buffer = json.at("buffer").get<std::size_t>();
    const auto offset = json.value("byteOffset", std::size_t{0}), length = json.at("byteLength").get<std::size_t>();
    const nlohmann::json& from = document.json.at("buffers").at(buffer);
    std::string bytes;
    if (!from.contains("uri")) bytes = document.binary;
    else if (const auto uri = from.at("uri").get<std::string>(); !decode_data_uri(uri, document.path, bytes))
      bytes = read_file(uri_path(document.path, uri));
    if (offset > bytes.size() || length > bytes.size() - offset)
      refuse_file(document.path, what + " goes beyond its buffer");
    return bytes.substr(offset, length);
  } catch (const nlohmann::json::exception&) {
    refuse_file(document.path, what + " is not there, or damaged");
  }
}

}  // namespace multum
