// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/gltf_check.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "host/base/error.h"

namespace multum {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw Error(ErrorCode::kInput, path + ": " + what);
}

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
  if (!file) refuse(path, "cannot be read");
  return text.str();
}

std::uint32_t little_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i > 0; --i) value = (value << 8) | static_cast<unsigned char>(bytes[at + i - 1]);
  return value;
}

/// GLB: 12 bytes of header ("glTF", version, length), then chunks of (length, type, data); the first one is JSON.
std::string glb_json(const std::string& bytes, const std::string& path) {
  constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
  if (bytes.size() < 20 || bytes.compare(0, 4, "glTF") != 0)
    refuse(path, "is not a GLB file: it does not begin with glTF");
  const std::size_t length = little_endian(bytes, 12);
  if (little_endian(bytes, 16) != kJsonChunk || length > bytes.size() - 20)
    refuse(path, "is a damaged GLB file: its JSON chunk of " + std::to_string(length) + " bytes is not all there");
  return bytes.substr(20, length);
}

// Extensions that leave positions, normals and uv set 0 as the core format has them.
bool leaves_geometry_alone(const std::string& extension) {
  for (const char* prefix : {"KHR_materials_", "KHR_lights_", "KHR_texture_basisu", "KHR_xmp", "EXT_texture_webp"})
    if (extension.compare(0, std::strlen(prefix), prefix) == 0) return true;
  return false;
}

}  // namespace

void check_gltf_file(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (extension != "gltf" && extension != "glb") return;
  const std::string bytes = read_file(path);
  const auto json = nlohmann::json::parse(extension == "glb" ? glb_json(bytes, path) : bytes, nullptr, false);
  if (!json.is_object()) refuse(path, "is damaged: its glTF JSON cannot be parsed");
  const auto required = json.find("extensionsRequired");
  if (required == json.end() || !required->is_array()) return;
  for (const auto& name : *required)
    if (name.is_string() && !leaves_geometry_alone(name.get<std::string>()))
      refuse(path,
             "requires the glTF extension " + name.get<std::string>() + ", which cannot be read; export without it");
}

}  // namespace multum
