// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/gltf_check.h"

#include <cstring>

#include "host/base/error.h"
#include "host/mesh/gltf_document.h"

namespace multum {
namespace {

// Extensions that leave positions, normals and uv set 0 as the core format has them.
bool leaves_geometry_alone(const std::string& extension) {
  for (const char* prefix : {"KHR_materials_", "KHR_lights_", "KHR_texture_basisu", "KHR_xmp", "EXT_texture_webp"})
    if (extension.compare(0, std::strlen(prefix), prefix) == 0) return true;
  return false;
}

}  // namespace

void check_gltf_file(const std::string& path) {
  if (!is_gltf_name(path)) return;
  const nlohmann::json json = read_gltf_document(path).json;
  const auto required = json.find("extensionsRequired");
  if (required == json.end() || !required->is_array()) return;
  for (const auto& name : *required)
    if (name.is_string() && !leaves_geometry_alone(name.get<std::string>()))
      refuse_file(
          path, "requires the glTF extension " + name.get<std::string>() + ", which cannot be read; export without it");
}

}  // namespace multum
