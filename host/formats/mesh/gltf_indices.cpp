// SPDX-License-Identifier: Apache-2.0
// Lists the indices of the glTF 2.0 specification, section 5, and of the schemas of its extensions.
#include "host/formats/mesh/gltf_indices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

// A place that has indices ("*" stands for each element or member), and the array to which they refer.
struct IndexRule {
  std::string_view place, target;
};

constexpr IndexRule kIndexRules[] = {
    {"scene", "scenes"},
    {"scenes/*/nodes/*", "nodes"},
    {"nodes/*/children/*", "nodes"},
    {"nodes/*/mesh", "meshes"},
    {"nodes/*/skin", "skins"},
    {"nodes/*/camera", "cameras"},
    {"nodes/*/extensions/EXT_mesh_gpu_instancing/attributes/*", "accessors"},
    {"nodes/*/extensions/KHR_lights_punctual/light", "extensions/KHR_lights_punctual/lights"},
    {"skins/*/inverseBindMatrices", "accessors"},
    {"skins/*/skeleton", "nodes"},
    {"skins/*/joints/*", "nodes"},
    {"meshes/*/primitives/*/attributes/*", "accessors"},
    {"meshes/*/primitives/*/indices", "accessors"},
    {"meshes/*/primitives/*/material", "materials"},
    {"meshes/*/primitives/*/targets/*/*", "accessors"},
    {"meshes/*/primitives/*/extensions/KHR_draco_mesh_compression/bufferView", "bufferViews"},
    {"meshes/*/primitives/*/extensions/KHR_materials_variants/mappings/*/material", "materials"},
    {"accessors/*/bufferView", "bufferViews"},
    {"accessors/*/sparse/indices/bufferView", "bufferViews"},
    {"accessors/*/sparse/values/bufferView", "bufferViews"},
    {"bufferViews/*/buffer", "buffers"},
    {"bufferViews/*/extensions/EXT_meshopt_compression/buffer", "buffers"},
    {"bufferViews/*/extensions/KHR_meshopt_compression/buffer", "buffers"},
    {"images/*/bufferView", "bufferViews"},
    {"textures/*/sampler", "samplers"},
    {"textures/*/source", "images"},
    {"textures/*/extensions/KHR_texture_basisu/source", "images"},
    {"textures/*/extensions/EXT_texture_webp/source", "images"},
    {"textures/*/extensions/EXT_texture_avif/source", "images"},
    {"textures/*/extensions/MSFT_texture_dds/source", "images"},
    {"animations/*/samplers/*/input", "accessors"},
    {"animations/*/samplers/*/output", "accessors"},
    {"animations/*/channels/*/target/node", "nodes"},
    {"materials/*/extensions/MULTUM_lobes/lobes", "extensions/MULTUM_lobes/lobes"},
    {"extensions/MULTUM_lobes/lobes/*/bufferView", "bufferViews"},
    {"extensions/MULTUM_lobes/lobes/*/colours/bufferView", "bufferViews"},
};

std::string_view next_word(std::string_view& place) {
  const std::string_view word = place.substr(0, place.find('/'));
  place.remove_prefix(std::min(word.size() + 1, place.size()));
  return word;
}

template <typename Json>
class IndexCheck {
 public:
  IndexCheck(const Json& json, const std::string& path) : json_(json), path_(path) {}

  void run() {
    for (const IndexRule& rule : kIndexRules) {
      const Json* target = found(json_, rule.target);
      const std::size_t count = target != nullptr && target->is_array() ? target->size() : 0;
      walk(json_, rule.place, "",
           [&](const Json& index, const std::string& place) { check(index, place, count, std::string(rule.target)); });
    }
    walk(json_, "animations/*", "", [&](const Json& animation, const std::string& place) {
      const Json* samplers = found(animation, "samplers");
      const std::size_t count = samplers != nullptr && samplers->is_array() ? samplers->size() : 0;
      walk(animation, "channels/*/sampler", place,
           [&](const Json& index, const std::string& where) { check(index, where, count, place + "/samplers"); });
    });
    const Json* textures = found(json_, "textures");
    texture_count_ = textures != nullptr && textures->is_array() ? textures->size() : 0;
    walk(json_, "materials/*", "",
         [&](const Json& material, const std::string& place) { textures_of(material, place); });
  }

 private:
  static const Json* found(const Json& in, std::string_view place) {
    const Json* at = &in;
    while (!place.empty()) {
      const std::string word(next_word(place));
      if (!at->is_object() || !at->contains(word)) return nullptr;
      at = &at->at(word);
    }
    return at;
  }

  // Calls use(value, place) for every value at the relative place `rest` in `value`. `at` is the place of `value`.
  template <typename Use>
  void walk(const Json& value, std::string_view rest, const std::string& at, const Use& use) const {
    if (rest.empty()) {
      use(value, at);
      return;
    }
    const std::string word(next_word(rest));
    const std::string prefix = at.empty() ? "" : at + "/";
    if (word != "*") {
      if (value.is_object() && value.contains(word)) walk(value.at(word), rest, prefix + word, use);
    } else if (value.is_structured()) {
      for (const auto& [key, child] : value.items()) walk(child, rest, prefix + key, use);
    }
  }

  // Checks the textures of a material, written as "...Texture": {"index": 1}, in the core format and in any extension.
  void textures_of(const Json& value, const std::string& place) const {
    if (!value.is_object()) return;
    for (const auto& [key, child] : value.items()) {
      if (key == "extras" || !child.is_object()) continue;
      if (place.ends_with("/extensions") && !key.starts_with("KHR_materials_") && key != "MULTUM_lobes") continue;
      const std::string where = place + "/" + key;
      if (key.ends_with("Texture") && child.contains("index"))
        check(child.at("index"), where + "/index", texture_count_, "textures");
      textures_of(child, where);
    }
  }

  void check(const Json& index, const std::string& place, std::size_t count, const std::string& target) const {
    if (index.is_number_unsigned() && index.template get<std::uint64_t>() < count) return;
    constexpr std::size_t kShownMax = 40;
    refuse_file(path_, fmt::format("{} is {}, expected a number below {}, the length of {}", place,
                                   json_text(index).substr(0, kShownMax), count, target));
  }

  const Json& json_;
  const std::string& path_;
  std::size_t texture_count_ = 0;
};

template <typename Json>
void check_indices(const Json& json, const std::string& path) {
  if (json.contains("asset") && json.at("asset").is_object() && json.at("asset").contains("version")) {
    const Json& version = json.at("asset").at("version");
    if (version.is_string() && version.template get_ref<const std::string&>().starts_with("1.")) return;
  }
  IndexCheck<Json>(json, path).run();
}

}  // namespace

void check_gltf_indices(const nlohmann::json& json, const std::string& path) { check_indices(json, path); }
void check_gltf_indices(const nlohmann::ordered_json& json, const std::string& path) { check_indices(json, path); }

}  // namespace multum
