// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/material_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/delivery/gltf/gltf_uses.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

struct TextureUse {
  std::size_t texture = 0;
  std::optional<std::size_t> image;  // the image, if it can be decoded
  std::array<WrapMode, 2> wrap{};
  TextureCoordinates coordinates;
};

class Planner {
 public:
  Planner(const GltfAsset& asset, bool is_anisotropic) : asset_(asset), is_anisotropic_(is_anisotropic) {
    find_pointers();
  }

  GltfPlan plan() {
    for (const GltfJson& material : asset_.array("materials")) {
      const std::size_t number = plan_.materials.size();
      const auto name = material.find("name");
      what_ = name != material.end() && name->is_string() && !name->get_ref<const std::string&>().empty()
                  ? name->get<std::string>()
                  : fmt::format("material {}", number);
      MaterialPlan made;
      made.name = what_;
      made.kept = plan_material(material, number, made);
      plan_.materials.push_back(std::move(made));
    }
    return std::move(plan_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { asset_.refuse(fmt::format("'{}': {}", what_, what)); }

  // Returns a child that is an object, or null if there is none.
  const GltfJson* object_at(const GltfJson& in, const char* key) const {
    const auto found = in.find(key);
    if (found == in.end()) return nullptr;
    if (!found->is_object()) refuse(fmt::format("{} is not an object", key));
    return &*found;
  }
  const GltfJson* extension_of(const GltfJson& in, const char* name) const {
    const GltfJson* all = object_at(in, "extensions");
    return all == nullptr ? nullptr : object_at(*all, name);
  }
  double number_at(const GltfJson& in, const char* key, double none) const {
    const auto found = in.find(key);
    if (found == in.end()) return none;
    if (!found->is_number()) refuse(fmt::format("{} is not a number", key));
    return found->get<double>();
  }
  double share_at(const GltfJson& in, const char* key) const {
    const double value = number_at(in, key, 1.0);
    if (!(value >= 0.0 && value <= 1.0)) refuse(fmt::format("{} is {}, expected 0 to 1", key, value));
    return value;
  }
  std::array<double, 2> pair_at(const GltfJson& in, const char* key, double none) const {
    const auto found = in.find(key);
    if (found == in.end()) return {none, none};
    if (!found->is_array() || found->size() != 2 || !found->at(0).is_number() || !found->at(1).is_number())
      refuse(fmt::format("{} is not two numbers", key));
    return {found->at(0).get<double>(), found->at(1).get<double>()};
  }

  // Finds the properties that KHR_animation_pointer animates.
  void find_pointers() {
    for (const GltfJson& animation : asset_.array("animations")) {
      const auto channels = animation.find("channels");
      if (channels == animation.end() || !channels->is_array()) continue;
      for (const GltfJson& channel : *channels) {
        const GltfJson::json_pointer place("/target/extensions/KHR_animation_pointer/pointer");
        if (channel.is_object() && channel.contains(place) && channel.at(place).is_string())
          pointers_.push_back(channel.at(place).get<std::string>());
      }
    }
  }
  bool is_animated(std::size_t material, const std::string& what) const {
    const std::string beginning = fmt::format("/materials/{}/{}", material, what);
    return std::any_of(pointers_.begin(), pointers_.end(),
                       [&](const std::string& pointer) { return pointer.starts_with(beginning); });
  }

  TextureCoordinates coordinates_of(const GltfJson& info) const {
    TextureCoordinates made;
    if (info.contains("texCoord") && !unsigned_at(info, "texCoord"))
      refuse("texCoord is not the index of a texture coordinate set");
    made.set = unsigned_at(info, "texCoord").value_or(0);
    if (const GltfJson* transform = extension_of(info, "KHR_texture_transform")) {
      made.offset = pair_at(*transform, "offset", 0.0);
      made.scale = pair_at(*transform, "scale", 1.0);
      made.rotation = number_at(*transform, "rotation", 0.0);
      made.set = unsigned_at(*transform, "texCoord").value_or(made.set);
    }
    return made;
  }

  std::array<WrapMode, 2> wrap_of(const GltfJson& texture) const {
    if (!texture.contains("sampler")) return {WrapMode::kPeriodic, WrapMode::kPeriodic};
    const GltfJson& sampler = asset_.array("samplers").at(asset_.index(texture, "sampler", "samplers"));
    const auto wrap = [&](const char* key) {
      constexpr std::uint64_t kRepeat = 10497, kClampToEdge = 33071, kMirroredRepeat = 33648;  // values of OpenGL
      const std::uint64_t code = sampler.contains(key) ? unsigned_at(sampler, key).value_or(0) : kRepeat;
      if (code != kRepeat && code != kClampToEdge && code != kMirroredRepeat)
        refuse(fmt::format("its sampler's {} is {}, expected {}, {} or {}", key, sampler.at(key).dump().substr(0, 40),
                           kRepeat, kClampToEdge, kMirroredRepeat));
      return code == kRepeat ? WrapMode::kPeriodic : code == kClampToEdge ? WrapMode::kClamp : WrapMode::kMirror;
    };
    return {wrap("wrapS"), wrap("wrapT")};
  }

  // Returns the image of a texture if it is a PNG, JPEG or WebP image.
  std::optional<std::size_t> image_of(const GltfJson& texture) const {
    std::vector<std::size_t> images;
    if (texture.contains("source")) images.push_back(asset_.index(texture, "source", "images"));
    if (const GltfJson* webp = extension_of(texture, "EXT_texture_webp"))
      images.push_back(asset_.index(*webp, "source", "images"));
    for (const std::size_t image : images) {
      const std::string type = gltf_image_type(read_gltf_image(asset_, image).bytes);
      if (type == "image/png" || type == "image/jpeg" || type == "image/webp") return image;
    }
    return std::nullopt;
  }

  std::optional<TextureUse> texture_at(const GltfJson& in, const char* key) const {
    const GltfJson* info = object_at(in, key);
    if (info == nullptr) return std::nullopt;
    TextureUse use;
    use.texture = asset_.index(*info, "index", "textures");
    const GltfJson& texture = asset_.array("textures").at(use.texture);
    use.coordinates = coordinates_of(*info);
    use.wrap = wrap_of(texture);
    use.image = image_of(texture);
    return use;
  }

  // Returns the reason why the material is not fitted. If the reason is empty, the material is fitted, and `made`
  // contains the inputs.
  std::string plan_material(const GltfJson& material, std::size_t number, MaterialPlan& made) {
    const std::optional<TextureUse> normal = texture_at(material, "normalTexture");
    if (!normal) return "it has no normal map";
    for (const char* name : {"KHR_materials_pbrSpecularGlossiness", "KHR_materials_unlit", "KHR_materials_anisotropy"})
      if (extension_of(material, name) != nullptr) return fmt::format("{} uses another reflection model", name);
    if (extension_of(material, "MULTUM_lobes") != nullptr) return "it already has lobes (MULTUM_lobes)";
    static const GltfJson kNone = GltfJson::object();
    const GltfJson* found = object_at(material, "pbrMetallicRoughness");
    const GltfJson& surface = found == nullptr ? kNone : *found;
    const std::optional<TextureUse> rough = texture_at(surface, "metallicRoughnessTexture");
    for (const char* what :
         {"normalTexture", "pbrMetallicRoughness/roughnessFactor", "pbrMetallicRoughness/metallicRoughnessTexture"})
      if (is_animated(number, what)) return fmt::format("an animation changes its {}", what);
    if (!normal->image) return "its normal texture has no PNG, JPEG or WebP image";
    if (rough && !rough->image) return "its metallic-roughness texture has no PNG, JPEG or WebP image";
    if (rough && rough->coordinates != normal->coordinates)
      return "the texture coordinates or texture transforms of its roughness and its normals differ";
    if (rough && rough->wrap != normal->wrap) return "its roughness wraps differently from its normals";

    made.coordinates = normal->coordinates;
    LobeSource source;
    source.normal_image = *normal->image;
    if (rough) source.surface_image = rough->image;
    source.wrap_s = normal->wrap[0];
    source.wrap_t = normal->wrap[1];
    source.normal_scale = number_at(*object_at(material, "normalTexture"), "scale", 1.0);
    constexpr double kScaleMax = 1e6;  // larger scales make all normals horizontal
    made.is_bad = !(std::abs(source.normal_scale) <= kScaleMax);
    if (made.is_bad)
      return fmt::format("normalTexture.scale is {:g}, expected at most {:g} in magnitude", source.normal_scale,
                         kScaleMax);
    source.roughness_factor = share_at(surface, "roughnessFactor");
    share_at(surface, "metallicFactor");
    source.has_occlusion = carries_occlusion(material, number, rough, made);
    source.is_anisotropic = is_anisotropic_;
    if (is_anisotropic_ && !normal->coordinates.keeps_axes()) {
      source.is_anisotropic = false;
      made.notes.push_back("its anisotropy was left out, because its texture transform rotates or mirrors the axes");
    }
    note_factors(source, made);
    const auto same = std::find(plan_.sources.begin(), plan_.sources.end(), source);
    made.source = static_cast<std::size_t>(same - plan_.sources.begin());
    const std::optional<std::size_t> colour = colour_image(surface, number, *normal);
    if (made.source == plan_.sources.size()) {
      plan_.sources.push_back(source);
      plan_.colour_images.push_back(colour);
    } else if (plan_.colour_images[made.source] != colour) {
      plan_.colour_images[made.source].reset();
    }
    return "";
  }

  // Returns the base colour image if it covers the same texels as the normals. Ignores errors in this image.
  std::optional<std::size_t> colour_image(const GltfJson& surface, std::size_t number, const TextureUse& normal) const {
    try {
      const std::optional<TextureUse> colour = texture_at(surface, "baseColorTexture");
      if (colour && colour->coordinates == normal.coordinates && colour->wrap == normal.wrap &&
          !is_animated(number, "pbrMetallicRoughness/baseColorTexture"))
        return colour->image;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kInput) throw;
    }
    return std::nullopt;
  }

  bool carries_occlusion(const GltfJson& material, std::size_t number, const std::optional<TextureUse>& rough,
                         MaterialPlan& made) const {
    const std::optional<TextureUse> occlusion = texture_at(material, "occlusionTexture");
    if (!occlusion || !rough || occlusion->image != rough->image) return false;
    if (occlusion->coordinates == rough->coordinates && occlusion->wrap == rough->wrap &&
        !is_animated(number, "occlusionTexture/extensions"))
      return true;
    made.notes.push_back(
        "occlusion still uses the original image, because the texture coordinates of occlusion and roughness differ");
    return false;
  }

  static void note_factors(const LobeSource& source, MaterialPlan& made) {
    if (source.normal_scale != 1.0)
      made.notes.push_back(fmt::format("its new texture includes normalTexture.scale {:g}", source.normal_scale));
    if (source.roughness_factor != 1.0)
      made.notes.push_back(fmt::format("its new texture includes roughnessFactor {:g}", source.roughness_factor));
  }

  const GltfAsset& asset_;
  const bool is_anisotropic_;
  std::vector<std::string> pointers_;
  std::string what_;
  GltfPlan plan_;
};

}  // namespace

GltfPlan plan_gltf(const GltfAsset& asset, bool is_anisotropic) { return Planner(asset, is_anisotropic).plan(); }

}  // namespace multum
