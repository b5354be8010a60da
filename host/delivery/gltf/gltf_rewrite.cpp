// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/gltf_rewrite.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "host/delivery/gltf/gltf_uses.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

enum class TextureRole { kNormal, kSurface, kAnisotropy };

// Identifies a new image.
struct ImageKey {
  std::size_t source = 0;
  TextureRole role = TextureRole::kNormal;
  auto operator<=>(const ImageKey&) const = default;
};

// A reference to a new texture.
struct TextureRequest {
  GltfJson::json_pointer info;  // the object with its "index"
  std::size_t old_texture = 0;  // the texture whose sampler and name are kept
  bool replaces = true;         // true if it replaces the old texture at this reference
  ImageKey image;
};

constexpr const char* kLobesExtension = "MULTUM_lobes";
constexpr int kLinearMipmapLinear = 9987, kLinearFilter = 9729;  // values of OpenGL

class GltfRewriter {
 public:
  GltfRewriter(const GltfAsset& asset, const GltfPlan& plan, const std::vector<SourceTextures>& textures)
      : asset_(asset), plan_(plan), sources_(textures), before_(gltf_uses(asset.json)) {
    made_.json = asset.json;
  }

  RewrittenGltf rewrite() {
    for (std::size_t m = 0; m < plan_.materials.size(); ++m)
      if (plan_.materials[m].kept.empty()) change_material(m);
      else if (plan_.materials[m].is_plain) keep_textures(made_.json["materials"][m], true, true);
    if (!requests_.empty() || !kept_.empty()) {
      place_textures();
      filter_by_levels();
      place_images();
      declare_extensions();
    }
    embed_images();
    return std::move(made_);
  }

 private:
  // Returns a top-level array, and creates the array if it is missing. Creating an array moves the other arrays, so do
  // not keep the reference.
  GltfJson& array(const char* name) {
    GltfJson& found = made_.json[name];
    if (found.is_null()) found = GltfJson::array();
    return found;
  }

  // Changes a material's texture properties. The texture indices are set later.
  void change_material(std::size_t number) {
    const MaterialPlan& plan = plan_.materials[number];
    const LobeSource& source = plan_.sources[plan.source];
    const SourceTextures& textures = sources_[plan.source];
    // Lobes are added first, because adding them moves `materials`.
    const std::size_t lobes = textures.lobes ? lobes_of(plan.source) : 0;
    GltfJson& material = made_.json["materials"][number];
    const GltfJson::json_pointer place("/materials/" + std::to_string(number));
    keep_textures(material, !textures.normal, !textures.surface);
    if (textures.lobes) material["extensions"][kLobesExtension] = lobes_object(material, lobes);
    GltfJson& normal = material["normalTexture"];
    const auto normal_texture = normal.at("index").get<std::size_t>();
    if (textures.normal && source.normal_scale != 1.0) normal.erase("scale");
    // A new kind of texture has the same texture coordinates as the normal texture.
    GltfJson beside = {{"index", normal_texture}};
    if (normal.contains("texCoord")) beside["texCoord"] = normal["texCoord"];
    if (normal.contains("extensions") && normal["extensions"].contains("KHR_texture_transform"))
      beside["extensions"]["KHR_texture_transform"] = normal["extensions"]["KHR_texture_transform"];
    if (textures.normal) request(place / "normalTexture", normal_texture, true, {plan.source, TextureRole::kNormal});
    if (textures.surface) {
      GltfJson& surface = material["pbrMetallicRoughness"];
      surface.erase("roughnessFactor");
      const bool had_one = surface.contains("metallicRoughnessTexture");
      if (!had_one) surface["metallicRoughnessTexture"] = beside;
      // Lobes use the original roughness, so the original texture is kept.
      request(place / "pbrMetallicRoughness" / "metallicRoughnessTexture",
              surface["metallicRoughnessTexture"].at("index").get<std::size_t>(), had_one && !textures.lobes,
              {plan.source, TextureRole::kSurface});
    }
    if (source.has_occlusion && textures.surface)
      request(place / "occlusionTexture", material["occlusionTexture"].at("index").get<std::size_t>(), true,
              {plan.source, TextureRole::kSurface});
    if (textures.anisotropy) {
      material["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", 1.0}, {"anisotropyTexture", beside}};
      request(place / "extensions" / "KHR_materials_anisotropy" / "anisotropyTexture", normal_texture, false,
              {plan.source, TextureRole::kAnisotropy});
    }
  }

  // Marks the material's own textures as kept. Their samplers will use mip levels.
  void keep_textures(const GltfJson& material, bool keeps_normal, bool keeps_surface) {
    const auto keep = [&](const GltfJson& in, const char* name) {
      if (const auto found = in.find(name); found != in.end()) kept_.insert(found->at("index").get<std::size_t>());
    };
    if (keeps_normal) keep(material, "normalTexture");
    if (const auto surface = material.find("pbrMetallicRoughness"); keeps_surface && surface != material.end())
      keep(*surface, "metallicRoughnessTexture");
  }

  // Returns the index of a source's lobes in the extension's array.
  std::size_t lobes_of(std::size_t source) {
    if (const auto found = lobes_.find(source); found != lobes_.end()) return found->second;
    GltfJson lobes = viewed(*sources_[source].lobes);
    if (sources_[source].lobe_colours) lobes["colours"] = viewed(*sources_[source].lobe_colours);
    GltfJson& all = made_.json["extensions"][kLobesExtension]["lobes"];
    if (!all.is_array()) all = GltfJson::array();
    all.push_back(std::move(lobes));
    return lobes_[source] = all.size() - 1;
  }

  // Adds a buffer view for the texture.
  GltfJson viewed(const EncodedTexture& texture) {
    const std::size_t view = array("bufferViews").size();
    array("bufferViews").push_back(GltfJson::object());
    made_.contents.emplace(view, ViewContent{"", texture.file, texture.byte_count});
    return {{"bufferView", view}, {"mimeType", texture.type}};
  }

  // Stores the material's original roughness, before the fit.
  static GltfJson lobes_object(const GltfJson& material, std::size_t lobes) {
    GltfJson made = {{"lobes", lobes}};
    const auto surface = material.find("pbrMetallicRoughness");
    if (surface == material.end()) return made;
    for (const char* name : {"roughnessFactor", "metallicRoughnessTexture"})
      if (surface->contains(name)) made[name] = surface->at(name);
    return made;
  }

  void request(const GltfJson::json_pointer& info, std::size_t old_texture, bool replaces, const ImageKey& image) {
    requests_.push_back({info, old_texture, replaces, image});
    if (replaces) ++replaced_[old_texture];
  }

  // Returns whether the old texture is no longer used.
  bool is_free(std::size_t texture) const {
    const auto found = replaced_.find(texture);
    return found != replaced_.end() && before_.texture_uses(texture) == found->second;
  }

  void place_textures() {
    using Key = std::tuple<ImageKey, GltfJson>;  // the same image and sampler
    std::vector<std::pair<Key, std::size_t>> placed;
    for (const TextureRequest& request : requests_) {
      const GltfJson old = asset_.array("textures").at(request.old_texture);
      Key key(request.image, old.value("sampler", GltfJson()));
      const auto same = std::find_if(placed.begin(), placed.end(), [&](const auto& one) { return one.first == key; });
      std::size_t at = same == placed.end() ? 0 : same->second;
      if (same == placed.end()) {
        const bool is_in_place =
            request.replaces && is_free(request.old_texture) && !new_textures_.contains(request.old_texture);
        at = is_in_place ? request.old_texture : array("textures").size();
        if (!is_in_place) array("textures").push_back(old);
        renew_texture(at, request.image);
        placed.emplace_back(std::move(key), at);
      }
      made_.json[request.info]["index"] = at;
      instead_.emplace(request.old_texture, at);
    }
    // If a replaced texture is no longer used, it becomes a copy of its replacement.
    for (const auto& [texture, at] : instead_)
      if (is_free(texture) && !new_textures_.contains(texture)) {
        array("textures")[texture] = GltfJson(array("textures")[at]);
        renew_texture(texture, new_textures_.at(at));
      }
  }

  // Removes all image references of the texture and keeps its sampler. The new image is set later.
  void renew_texture(std::size_t number, const ImageKey& image) {
    GltfJson& texture = array("textures")[number];
    texture.erase("source");
    if (texture.contains("extensions")) {
      GltfJson& extensions = texture["extensions"];
      for (auto one = extensions.begin(); one != extensions.end();)
        one = is_image_extension(one.key()) ? extensions.erase(one) : one + 1;
      if (extensions.empty()) texture.erase("extensions");
    }
    new_textures_.emplace(number, image);
  }

  // Returns the normal and surface textures whose samplers must filter between levels.
  std::set<std::size_t> filtered_textures() {
    std::set<std::size_t> made;
    for (const auto& [number, image] : new_textures_) made.insert(number);
    // If there is no minFilter, renderers choose how to filter between levels.
    for (const std::size_t number : kept_)
      if (const auto sampler = unsigned_at(array("textures").at(number), "sampler");
          sampler && array("samplers").at(*sampler).contains("minFilter"))
        made.insert(number);
    return made;
  }

  // Samplers that other textures also use are not changed.
  void filter_by_levels() {
    const std::set<std::size_t> filtered = filtered_textures();
    std::set<std::size_t> others;
    for (std::size_t t = 0; t < array("textures").size(); ++t)
      if (const auto sampler = unsigned_at(array("textures")[t], "sampler"); sampler && !filtered.contains(t))
        others.insert(*sampler);
    std::vector<std::pair<GltfJson, std::size_t>> added;
    for (const std::size_t number : filtered) {
      const auto old = unsigned_at(array("textures")[number], "sampler");
      GltfJson sampler = GltfJson::object();
      if (old) sampler = array("samplers").at(*old);
      else sampler["magFilter"] = kLinearFilter;
      if (old && unsigned_at(sampler, "minFilter") == kLinearMipmapLinear) continue;
      sampler["minFilter"] = kLinearMipmapLinear;
      if (old && !others.contains(*old) && !before_.unknown.contains(*old)) {
        array("samplers")[*old] = sampler;
        continue;
      }
      const auto same = std::find_if(added.begin(), added.end(), [&](const auto& one) { return one.first == sampler; });
      const std::size_t at = same == added.end() ? array("samplers").size() : same->second;
      if (same == added.end()) {
        array("samplers").push_back(sampler);
        added.emplace_back(std::move(sampler), at);
      }
      array("textures")[number]["sampler"] = at;
    }
  }

  const EncodedTexture& encoded(const ImageKey& key) const {
    const SourceTextures& textures = sources_[key.source];
    const std::optional<EncodedTexture>& found = key.role == TextureRole::kNormal    ? textures.normal
                                                 : key.role == TextureRole::kSurface ? textures.surface
                                                                                     : textures.anisotropy;
    MULTUM_CHECK(found.has_value());
    return *found;
  }

  std::optional<std::size_t> image_before(const ImageKey& key) const {
    const LobeSource& source = plan_.sources[key.source];
    if (key.role == TextureRole::kNormal) return source.normal_image;
    return key.role == TextureRole::kSurface ? source.surface_image : std::nullopt;
  }

  void place_images() {
    const GltfUses after = gltf_uses(made_.json);
    std::map<ImageKey, std::size_t> placed, fallbacks;
    for (const auto& [number, key] : new_textures_)
      if (const std::optional<FallbackImage>& one = encoded(key).fallback; one && one->file.empty())
        fallbacks[key] = *image_before(key);
    const auto is_fallback = [&](std::size_t image) {
      return std::any_of(fallbacks.begin(), fallbacks.end(), [&](const auto& one) { return one.second == image; });
    };
    for (const auto& [number, key] : new_textures_) {
      const EncodedTexture& texture = encoded(key);
      const auto same = placed.find(key);
      std::size_t at = same == placed.end() ? array("images").size() : same->second;
      if (same == placed.end()) {
        const std::optional<std::size_t> old = image_before(key);
        const bool is_in_place =
            old && after.image_uses(*old) == 0 && !renewed_images_.contains(*old) && !is_fallback(*old);
        if (is_in_place) at = *old;
        else array("images").push_back(GltfJson::object());
        renewed_images_.insert(at);
        give_bytes(at, texture.type, {"", texture.file, texture.byte_count});
        placed.emplace(key, at);
        if (texture.fallback && !fallbacks.contains(key)) {
          fallbacks[key] = array("images").size();
          array("images").push_back(GltfJson::object());
          renewed_images_.insert(fallbacks[key]);
          give_bytes(fallbacks[key], "image/png", {"", texture.fallback->file, texture.fallback->byte_count});
        }
      }
      GltfJson& object = array("textures")[number];
      if (texture.type == "image/ktx2") object["extensions"]["KHR_texture_basisu"] = {{"source", at}};
      else object["source"] = at;
      if (const auto fallback = fallbacks.find(key); fallback != fallbacks.end()) object["source"] = fallback->second;
    }
  }

  // Stores an image's bytes in the image's own buffer view if nothing else uses this view, otherwise in a new view.
  void give_bytes(std::size_t number, const std::string& type, ViewContent content) {
    if (content.byte_count == 0) content.byte_count = content.bytes.size();
    const auto old = unsigned_at(array("images")[number], "bufferView");
    const bool is_in_place = old && before_.view_uses(*old) == 1;
    const std::size_t view = is_in_place ? static_cast<std::size_t>(*old) : array("bufferViews").size();
    if (!is_in_place) array("bufferViews").push_back(GltfJson::object());
    GltfJson& image = array("images")[number];
    image.erase("uri");
    image["mimeType"] = type;
    image["bufferView"] = view;
    made_.contents.emplace(view, std::move(content));
  }

  // Embeds all images into the GLB.
  void embed_images() {
    for (std::size_t i = 0; i < asset_.array("images").size(); ++i) {
      const GltfJson& image = asset_.array("images").at(i);
      if (renewed_images_.contains(i) || image.contains("bufferView")) continue;
      GltfImageBytes read = read_gltf_image(asset_, i);
      const std::string type = gltf_image_type(read.bytes);
      if (!type.empty()) give_bytes(i, type, {std::move(read.bytes), "", 0});
      else made_.left_outside.push_back(image.at("uri").get<std::string>().substr(0, 200));
    }
  }

  void declare(const char* list, const std::string& name) {
    GltfJson& names = array(list);
    if (std::find(names.begin(), names.end(), GltfJson(name)) == names.end()) names.push_back(name);
  }

  void declare_extensions() {
    for (const auto& [number, key] : new_textures_) {
      if (encoded(key).type == "image/ktx2") {
        declare("extensionsUsed", "KHR_texture_basisu");
        if (!encoded(key).fallback) declare("extensionsRequired", "KHR_texture_basisu");
      }
      if (key.role == TextureRole::kAnisotropy) declare("extensionsUsed", "KHR_materials_anisotropy");
    }
    if (!lobes_.empty()) declare("extensionsUsed", kLobesExtension);
  }

  const GltfAsset& asset_;
  const GltfPlan& plan_;
  const std::vector<SourceTextures>& sources_;
  const GltfUses before_;
  RewrittenGltf made_;
  std::vector<TextureRequest> requests_;
  std::map<std::size_t, int> replaced_;           // uses of old textures that new ones replace
  std::map<std::size_t, ImageKey> new_textures_;  // by index of the texture
  std::map<std::size_t, std::size_t> instead_;    // old texture -> its first replacement
  std::set<std::size_t> kept_;                    // kept textures of drawn materials
  std::set<std::size_t> renewed_images_;
  std::map<std::size_t, std::size_t> lobes_;  // index in the extension's array, by source
};

}  // namespace

RewrittenGltf rewrite_gltf(const GltfAsset& asset, const GltfPlan& plan, const std::vector<SourceTextures>& textures) {
  return GltfRewriter(asset, plan, textures).rewrite();
}

}  // namespace multum
