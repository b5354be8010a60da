// SPDX-License-Identifier: Apache-2.0
// The manifest of inferred textures as JSON.

#include "host/fields/inferred/inferred_texture.h"
#include "host/fields/inferred/manifest_json.h"
#include "host/fields/inferred/matrix_json.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"

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

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::kInput, what); }

void check(const InferredManifest& manifest) {
  check_samples(manifest);
  for (const InferredObject& object : manifest.objects) {
    check_mappings(manifest, object);
    for (const InferredLayer& layer : object.layers)
      if (layer.textures.size() != manifest.samples.size())
        refuse("layer '" + layer.name + "' of object '" + object.name + "' has " +
               std::to_string(layer.textures.size()) + " textures for " + std::to_string(manifest.samples.size()) +
               " samples");
  }
}

// Throws Error without the file's name, which the caller knows.
InferredManifest manifest_from(const nlohmann::json& json) {
  if (json_int(json, "multumInferredTextures") != 1) refuse("is a manifest of another version, expected 1");
  InferredManifest manifest;
  read_scene_keys(json, manifest);
  for (const nlohmann::json& sample : json.at("samples")) manifest.samples.push_back(sample_from(sample));
  for (const nlohmann::json& object : json.at("objects")) manifest.objects.push_back(object_from(object));
  check(manifest);
  return manifest;
}

}  // namespace

void write_inferred_manifest(const InferredManifest& manifest, const std::string& path) {
  nlohmann::json samples = nlohmann::json::array(), objects = nlohmann::json::array();
  for (const InferredSample& sample : manifest.samples) samples.push_back(sample_json(sample));
  for (const InferredObject& object : manifest.objects) objects.push_back(object_json(object));
  nlohmann::json json = scene_keys_json(manifest);
  json["multumInferredTextures"] = 1;
  json["samples"] = std::move(samples);
  json["objects"] = std::move(objects);
  write_text_file(path, json_text(json, 1) + "\n");
}

InferredManifest read_inferred_manifest(const std::string& path) {
  const std::optional<std::string> text = json_of_file(path);
  if (!text) throw Error(ErrorCode::kInput, path + ": cannot be read");
  try {
    return manifest_from(nlohmann::json::parse(*text));
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorCode::kInput, path + ": is not a manifest of inferred textures: " + error.what());
  }
}

}  // namespace multum
