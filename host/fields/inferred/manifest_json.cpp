// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inferred/manifest_json.h"

#include <fmt/format.h>

#include "host/fields/inferred/matrix_json.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"

namespace multum {

nlohmann::json scene_keys_json(const InferredManifest& manifest) {
  return {{"geometry", text_of_path(manifest.geometry_file)},
          {"geometryHash", manifest.geometry_hash},
          {"uvSet", manifest.uv_set},
          {"width", manifest.width},
          {"height", manifest.height},
          {"supersampling", manifest.supersampling},
          {"parameters", manifest.parameters}};
}

void read_scene_keys(const nlohmann::json& json, InferredManifest& manifest) {
  manifest.geometry_file = path_of_text(json.at("geometry").get<std::string>());
  manifest.geometry_hash = json.at("geometryHash").get<std::string>();
  manifest.uv_set = json_int(json, "uvSet");
  manifest.width = json_int(json, "width");
  manifest.height = json_int(json, "height");
  manifest.supersampling = json_int(json, "supersampling");
  check_picture_size(manifest.width, manifest.height, manifest.supersampling);
  manifest.parameters = json.at("parameters").get<std::vector<std::string>>();
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
      throw Error(ErrorCode::kInput, fmt::format("object '{}' has mapping {} at a sample, expected one of its {}",
                                                 object.name, number, object.mappings.size()));
}

}  // namespace multum
