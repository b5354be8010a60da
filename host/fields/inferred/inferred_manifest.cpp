// SPDX-License-Identifier: Apache-2.0
// Reads and writes the manifest of inferred textures as JSON.
#include <fmt/format.h>

#include "host/fields/inferred/inferred_texture.h"
#include "host/fields/inferred/manifest_json.h"
#include "host/fields/inferred/matrix_json.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

nlohmann::json sample_json(const InferredSample& sample) {
  nlohmann::json moved = nlohmann::json::object();
  for (const auto& [name, matrix] : sample.object_to_world) moved[name] = matrix_json(matrix);
  return {{"name", sample.name},
          {"at", sample.at},
          {"worldToClip", matrix_json(sample.world_to_clip)},
          {"objectToWorld", moved}};
}

nlohmann::json object_json(const InferredObject& object) {
  nlohmann::json layers = nlohmann::json::array();
  for (const InferredLayer& layer : object.layers)
    layers.push_back({{"name", layer.name}, {"textures", layer.textures}});
  return {{"name", object.name},
          {"mesh", object.mesh},
          {"mappings", object.mappings},
          {"mappingOfSample", object.mapping_of_sample},
          {"anisotropy", object.anisotropy},
          {"layers", layers}};
}

InferredSample sample_from(const nlohmann::json& json) {
  InferredSample sample;
  sample.name = json.at("name").get<std::string>();
  sample.at = json_ints(json, "at");
  sample.world_to_clip = matrix_from_json(json.at("worldToClip"));
  for (const auto& [name, matrix] : json.at("objectToWorld").items())
    sample.object_to_world[name] = matrix_from_json(matrix);
  return sample;
}

InferredObject object_from(const nlohmann::json& json) {
  InferredObject object;
  object.name = json.at("name").get<std::string>();
  object.mesh = json.at("mesh").get<std::string>();
  object.mappings = json.at("mappings").get<std::vector<TextureMapping>>();
  object.mapping_of_sample = json_ints(json, "mappingOfSample");
  object.anisotropy = anisotropy_from_json(json.at("anisotropy"));
  for (const nlohmann::json& layer : json.at("layers"))
    object.layers.push_back(
        {layer.at("name").get<std::string>(), layer.at("textures").get<std::vector<std::string>>()});
  return object;
}

void check_samples(const InferredManifest& manifest) {
  if (manifest.samples.empty()) throw Error(ErrorCode::kInput, "has no samples");
  for (const InferredSample& sample : manifest.samples)
    if (sample.at.size() != manifest.parameters.size())
      throw Error(ErrorCode::kInput, fmt::format("sample '{}' has {} indices, expected {}", sample.name,
                                                 sample.at.size(), manifest.parameters.size()));
}

void check_mappings(const InferredManifest& manifest, const InferredObject& object) {
  const std::vector<int>& of_sample = object.mapping_of_sample;
  if (of_sample.size() != manifest.samples.size())
    throw Error(ErrorCode::kInput, fmt::format("object '{}' has mappingOfSample for {} of {} samples", object.name,
                                               of_sample.size(), manifest.samples.size()));
  for (const int number : of_sample)
    if (number < 0 || number >= std::ssize(object.mappings))
      throw Error(ErrorCode::kInput,
                  fmt::format("object '{}' uses mapping {} at a sample, expected one of its {} mappings", object.name,
                              number, object.mappings.size()));
}

void check_textures(const InferredManifest& manifest) {
  for (const InferredObject& object : manifest.objects)
    for (const InferredLayer& layer : object.layers)
      if (layer.textures.size() != manifest.samples.size())
        throw Error(ErrorCode::kInput,
                    fmt::format("layer '{}' of object '{}' has {} textures for {} samples", layer.name, object.name,
                                layer.textures.size(), manifest.samples.size()));
}

}  // namespace

nlohmann::json scene_json(const InferredManifest& manifest) {
  nlohmann::json samples = nlohmann::json::array(), objects = nlohmann::json::array();
  for (const InferredSample& sample : manifest.samples) samples.push_back(sample_json(sample));
  for (const InferredObject& object : manifest.objects) objects.push_back(object_json(object));
  return {{"geometry", text_of_path(manifest.geometry_file)},
          {"geometryHash", manifest.geometry_hash},
          {"uvSet", manifest.uv_set},
          {"width", manifest.width},
          {"height", manifest.height},
          {"supersampling", manifest.supersampling},
          {"parameters", manifest.parameters},
          {"samples", std::move(samples)},
          {"objects", std::move(objects)}};
}

InferredManifest scene_from(const nlohmann::json& json) {
  InferredManifest manifest;
  manifest.geometry_file = path_of_text(json.at("geometry").get<std::string>());
  manifest.geometry_hash = json.at("geometryHash").get<std::string>();
  manifest.uv_set = json_int(json, "uvSet");
  manifest.width = json_int(json, "width");
  manifest.height = json_int(json, "height");
  manifest.supersampling = json_int(json, "supersampling");
  check_picture_size(manifest.width, manifest.height, manifest.supersampling);
  manifest.parameters = json.at("parameters").get<std::vector<std::string>>();
  for (const nlohmann::json& sample : json.at("samples")) manifest.samples.push_back(sample_from(sample));
  check_samples(manifest);
  for (const nlohmann::json& object : json.at("objects")) {
    manifest.objects.push_back(object_from(object));
    check_mappings(manifest, manifest.objects.back());
  }
  return manifest;
}

void write_inferred_manifest(const InferredManifest& manifest, const std::string& path) {
  nlohmann::json json = scene_json(manifest);
  json["multumInferredTextures"] = 1;
  write_text_file(path, json_text(json, 1) + "\n");
}

InferredManifest read_inferred_manifest(const std::string& path) {
  const std::optional<std::string> text = json_of_file(path);
  if (!text) throw Error(ErrorCode::kInput, path + ": cannot be read");
  try {
    const nlohmann::json json = nlohmann::json::parse(*text);
    if (json_int(json, "multumInferredTextures") != 1)
      throw Error(ErrorCode::kInput, "has another manifest version, expected version 1");
    InferredManifest manifest = scene_from(json);
    check_textures(manifest);
    return manifest;
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorCode::kInput, path + ": is not a manifest of inferred textures: " + error.what());
  }
}

}  // namespace multum
