// SPDX-License-Identifier: Apache-2.0
#include "host/formats/mesh/gltf_check.h"

#include <cstring>

#include "host/formats/mesh/gltf_document.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

// Returns whether positions, normals and uv set 0 have the same meaning as in the core format if an extension is used.
bool leaves_geometry_alone(const std::string& extension) {
  for (const char* prefix : {"KHR_materials_", "KHR_lights_", "KHR_texture_basisu", "KHR_xmp", "EXT_texture_webp"})
    if (extension.compare(0, std::strlen(prefix), prefix) == 0) return true;
  return false;
}

// Opens the files that buffers name, because assimp gives almost no reason if it cannot open them.
void check_buffers(const nlohmann::json& json, const std::string& path) {
  const auto buffers = json.find("buffers");
  if (buffers == json.end() || !buffers->is_array()) return;
  for (const nlohmann::json& buffer : *buffers) {
    if (!buffer.is_object() || !buffer.contains("uri")) continue;
    const nlohmann::json& uri = buffer.at("uri");
    if (!uri.is_string()) refuse_file(path, "is damaged: a buffer's URI is not a string");
    if (!uri.get_ref<const std::string&>().starts_with("data:")) uri_path(path, uri.get_ref<const std::string&>());
    const bool has_length = buffer.contains("byteLength");
    if (has_length) json_integer(buffer, "byteLength", 0, static_cast<std::int64_t>(kModelBytesMax));
  }
}

}  // namespace

void check_gltf_file(const std::string& path) {
  if (!is_gltf_name(path)) return;
  const nlohmann::json json = read_gltf_document(path).json;
  check_buffers(json, path);
  const auto required = json.find("extensionsRequired");
  if (required == json.end() || !required->is_array()) return;
  for (const auto& name : *required)
    if (name.is_string() && !leaves_geometry_alone(name.get<std::string>()))
      refuse_file(path, "requires the glTF extension " + name.get<std::string>() +
                            ", which cannot be read; export the model without it");
}

}  // namespace multum
