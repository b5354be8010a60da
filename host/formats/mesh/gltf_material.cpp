// SPDX-License-Identifier: Apache-2.0
#include "host/formats/mesh/gltf_material.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "host/formats/mesh/gltf_document.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

using nlohmann::json;

constexpr int kRepeat = 10497, kClampToEdge = 33071, kMirroredRepeat = 33648;  // OpenGL's codes, as glTF stores them

std::string unique(std::string name, std::set<std::string>& taken) {
  const std::string first = name;
  for (int n = 2; !taken.insert(name).second; ++n) name = fmt::format("{} ({})", first, n);
  return name;
}

class MaterialReader {
 public:
  explicit MaterialReader(const std::string& path) : document_(read_gltf_document(path)) {}

  GltfMaterials read() {
    const json empty = json::array();
    std::set<std::string> image_names, material_names;
    for (const json& image : array("images")) result_.images.push_back(read_image(image, image_names));
    for (const json& material : array("materials")) {
      const std::string number = fmt::format("material {}", result_.materials.size());
      const std::string name = material.value("name", "");
      result_.materials.push_back(read_material(material, unique(name.empty() ? number : name, material_names)));
    }
    return std::move(result_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ErrorCode::kInput, document_.path + ": " + what);
  }

  const json& array(const char* name) const {
    static const json kEmpty = json::array();
    const auto found = document_.json.find(name);
    return found == document_.json.end() ? kEmpty : *found;
  }

  static std::size_t index_at(const json& object, const char* key) {
    return static_cast<std::size_t>(json_integer(object, key, 0, INT32_MAX));
  }
  static int uv_set_of(const json& info) {
    return info.contains("texCoord") ? static_cast<int>(json_integer(info, "texCoord", 0, INT32_MAX)) : 0;
  }

  GltfImage read_image(const json& image, std::set<std::string>& names) const {
    GltfImage made;
    const std::string number = fmt::format("image_{}", names.size());
    const std::string uri = image.value("uri", "");
    if (image.contains("bufferView")) made.bytes = buffer_view_bytes(document_, index_at(image, "bufferView"));
    else if (uri.empty()) refuse(number + " has neither a URI nor a buffer view");
    else if (!decode_data_uri(uri, document_.path, made.bytes)) made.file = uri_path(document_.path, uri);
    made.name = unique(image.value("name", "").empty() ? number : safe_file_name(image.value("name", "")), names);
    if (made.file.empty()) made.extension = extension_of(made.bytes, number);
    return made;
  }

  // Detects the format from the bytes, because name and type may be wrong.
  std::string extension_of(const std::string& bytes, const std::string& number) const {
    if (bytes.starts_with("\x89PNG")) return "png";
    if (bytes.starts_with("\xff\xd8\xff")) return "jpg";
    if (bytes.starts_with("RIFF") && bytes.substr(8, 4) == "WEBP") return "webp";
    if (bytes.starts_with("\xabKTX 20\xbb")) return "ktx2";
    refuse(number + " is not PNG, JPEG, WebP or KTX2; export it as one of these");
  }

  GltfMaterial read_material(const json& material, const std::string& name) const {
    GltfMaterial made;
    made.name = name;
    const json none = json::object();
    const json& surface = material.contains("pbrMetallicRoughness") ? material.at("pbrMetallicRoughness") : none;
    if (surface.contains("baseColorFactor"))
      for (int c = 0; c < 4; ++c)
        made.base_colour[c] = surface.at("baseColorFactor").at(static_cast<std::size_t>(c)).get<float>();
    made.metallic = surface.value("metallicFactor", 1.0f);
    made.roughness = surface.value("roughnessFactor", 1.0f);
    made.colour = read_texture(surface, "baseColorTexture", name);
    made.metallic_roughness = read_texture(surface, "metallicRoughnessTexture", name);
    made.normal = read_texture(material, "normalTexture", name);
    if (made.normal) made.normal_scale = material.at("normalTexture").value("scale", 1.0f);
    if (material.contains("extensions") && material.at("extensions").contains("KHR_materials_anisotropy"))
      made.anisotropy = material.at("extensions").at("KHR_materials_anisotropy").value("anisotropyStrength", 0.0f);
    for (const float value :
         {made.base_colour.r, made.base_colour.g, made.base_colour.b, made.metallic, made.roughness, made.anisotropy})
      if (!(value >= 0.0f && value <= 1.0f))
        refuse(fmt::format("material '{}' has a factor of {}, expected 0 to 1", name, value));
    if (!std::isfinite(made.normal_scale))
      refuse(fmt::format("material '{}' has a normal scale that is not a number", name));
    return made;
  }

  std::optional<GltfTexture> read_texture(const json& in, const char* key, const std::string& material) const {
    if (!in.contains(key)) return std::nullopt;
    const json& info = in.at(key);
    GltfTexture made;
    made.uv_set = uv_set_of(info);
    check_transform(info, key, material);
    const std::size_t index = index_at(info, "index");
    const json& textures = array("textures");
    if (index >= textures.size())
      refuse(fmt::format("material '{}' refers to texture {} of {}", material, index, textures.size()));
    const json& texture = textures.at(index);
    std::size_t image = result_.images.size();
    const json& more = texture.contains("extensions") ? texture.at("extensions") : json::object();
    if (more.contains("EXT_texture_webp")) image = index_at(more.at("EXT_texture_webp"), "source");
    if (image == result_.images.size() && texture.contains("source")) image = index_at(texture, "source");
    // This format is the last choice, because only GPU libraries can decode some of its texels.
    if (image == result_.images.size() && more.contains("KHR_texture_basisu"))
      image = index_at(more.at("KHR_texture_basisu"), "source");
    if (image >= result_.images.size()) refuse(fmt::format("texture {} has no readable image", index));
    made.image = static_cast<int>(image);
    if (texture.contains("sampler")) {
      const json& sampler = array("samplers").at(index_at(texture, "sampler"));
      made.wrap_s = wrap_name(sampler.contains("wrapS") ? json_int(sampler, "wrapS") : kRepeat);
      made.wrap_t = wrap_name(sampler.contains("wrapT") ? json_int(sampler, "wrapT") : kRepeat);
    }
    return made;
  }

  // Rejects a texture transform. A rotation of the texture would also require a rotation of its normals, which is not
  // implemented.
  void check_transform(const json& info, const char* key, const std::string& material) const {
    if (!info.contains("extensions") || !info.at("extensions").contains("KHR_texture_transform")) return;
    const json& transform = info.at("extensions").at("KHR_texture_transform");
    const json zero = {0.0, 0.0}, one = {1.0, 1.0};
    const bool changes = transform.value("offset", zero) != zero || transform.value("scale", one) != one ||
                         transform.value("rotation", 0.0) != 0.0 ||
                         (transform.contains("texCoord") && uv_set_of(transform) != uv_set_of(info));
    if (changes)
      refuse(
          fmt::format("material '{}' transforms its {} with KHR_texture_transform, which is not supported; apply it to "
                      "the texture coordinates and export again",
                      material, key));
  }

  const char* wrap_name(int mode) const {
    switch (mode) {
      case kRepeat: return "periodic";
      case kClampToEdge: return "clamp";
      case kMirroredRepeat: return "mirror";
    }
    refuse(
        fmt::format("a sampler has wrap mode {}, expected {}, {} or {}", mode, kRepeat, kClampToEdge, kMirroredRepeat));
  }

  const GltfDocument document_;
  GltfMaterials result_;
};

}  // namespace

std::string safe_file_name(const std::string& name) {
  std::string safe;
  for (const char c : name) safe += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' ? c : '_';
  return safe;
}

GltfMaterials read_gltf_materials(const std::string& path) {
  if (!is_gltf_name(path)) throw Error(ErrorCode::kInput, path + ": expected a glTF file, *.gltf or *.glb");
  try {
    return MaterialReader(path).read();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInput || std::string_view(error.what()).starts_with(path)) throw;
    refuse_file(path, std::string("is damaged: ") + error.what());
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorCode::kInput, path + ": is damaged: its materials or textures do not follow the glTF format");
  }
}

std::string extract_image(const GltfImage& image, const std::string& folder) {
  if (!image.file.empty()) return image.file;
  const std::string path = folder + "/" + image.name + "." + image.extension;
  write_text_file(path, image.bytes);
  return path;
}

}  // namespace multum
