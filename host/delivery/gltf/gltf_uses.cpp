// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/gltf_uses.h"

#include <string_view>

namespace multum {
namespace {

// The extensions whose references can be found by the rules of Walk. Textures have the form "...Texture": {"index": 1},
// images are "source" in a texture, and buffer views are "bufferView".
constexpr std::string_view kKnownExtensions[] = {"KHR_materials_anisotropy",
                                                 "KHR_materials_clearcoat",
                                                 "KHR_materials_diffuse_transmission",
                                                 "KHR_materials_dispersion",
                                                 "KHR_materials_emissive_strength",
                                                 "KHR_materials_ior",
                                                 "KHR_materials_iridescence",
                                                 "KHR_materials_pbrSpecularGlossiness",
                                                 "KHR_materials_sheen",
                                                 "KHR_materials_specular",
                                                 "KHR_materials_transmission",
                                                 "KHR_materials_unlit",
                                                 "KHR_materials_variants",
                                                 "KHR_materials_volume",
                                                 "KHR_texture_transform",
                                                 "KHR_texture_basisu",
                                                 "EXT_texture_webp",
                                                 "EXT_texture_avif",
                                                 "MSFT_texture_dds",
                                                 "KHR_mesh_quantization",
                                                 "KHR_draco_mesh_compression",
                                                 "EXT_meshopt_compression",
                                                 "KHR_meshopt_compression",
                                                 "EXT_mesh_gpu_instancing",
                                                 "KHR_lights_punctual",
                                                 "KHR_animation_pointer",
                                                 "KHR_node_visibility",
                                                 "KHR_xmp_json_ld",
                                                 "MULTUM_lobes"};

bool is_known(std::string_view name) {
  for (const std::string_view known : kKnownExtensions)
    if (known == name) return true;
  return false;
}

class Walk {
 public:
  explicit Walk(GltfUses& uses) : uses_(uses) {}

  void known(const GltfJson& value, bool is_image_source) {
    if (value.is_array())
      for (const GltfJson& one : value) known(one, is_image_source);
    if (!value.is_object()) return;
    for (const auto& [key, child] : value.items()) {
      if (key == "extras") continue;
      if (key == "extensions") {
        extensions(child, is_image_source);
        continue;
      }
      if (is_image_source && key == "source") count(uses_.images, child);
      if (key == "bufferView") count(uses_.views, child);
      if (key.ends_with("Texture") && child.is_object() && child.contains("index"))
        count(uses_.textures, child.at("index"));
      // Only the "source" of a texture itself is an image.
      known(child, is_image_source && child.is_array());
    }
  }
  void extensions(const GltfJson& all, bool is_image_source) {
    if (!all.is_object()) return;
    for (const auto& [name, extension] : all.items())
      if (is_known(name)) known(extension, is_image_source && is_image_extension(name));
      else all_integers(extension);
  }

 private:
  void all_integers(const GltfJson& value) {
    if (value.is_number_unsigned()) uses_.unknown.insert(value.get<std::uint64_t>());
    if (value.is_structured())
      for (const GltfJson& one : value) all_integers(one);
  }
  static void count(std::map<std::uint64_t, int>& of, const GltfJson& index) {
    if (index.is_number_unsigned()) ++of[index.get<std::uint64_t>()];
  }

  GltfUses& uses_;
};

}  // namespace

bool is_image_extension(const std::string& name) {
  return name == "KHR_texture_basisu" || name == "EXT_texture_webp" || name == "EXT_texture_avif" ||
         name == "MSFT_texture_dds";
}

GltfUses gltf_uses(const GltfJson& json) {
  GltfUses uses;
  Walk walk(uses);
  for (const auto& [key, value] : json.items()) {
    if (key == "extensions") walk.extensions(value, false);
    else if (key != "extras") walk.known(value, key == "textures");
  }
  return uses;
}

}  // namespace multum
