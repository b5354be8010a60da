// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inferred/field_files.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "host/fields/inferred/inference_error.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/input_hashes.h"

namespace multum {

ObjectPoses object_poses(const InferredManifest& field, const InferredObject& object) {
  ObjectPoses poses;
  for (std::size_t s = 0; s < field.samples.size(); ++s) {
    const auto found = std::find_if(poses.first_samples.begin(), poses.first_samples.end(), [&](std::size_t first) {
      return field.samples[first].world_to_clip == field.samples[s].world_to_clip &&
             field.samples[first].object_to_world == field.samples[s].object_to_world &&
             object.mapping_of_sample[first] == object.mapping_of_sample[s];
    });
    poses.of_sample.push_back(static_cast<std::size_t>(found - poses.first_samples.begin()));
    if (found == poses.first_samples.end()) poses.first_samples.push_back(s);
  }
  return poses;
}

std::string matrix_name(const InferredSample& sample, const InferredObject& object) {
  return "matrices/" + sample.name + "_" + object.name + ".fmx";
}

std::string geometry_path(const InferredManifest& field, const std::string& folder) {
  return (std::filesystem::path(folder) / field.geometry_file).lexically_normal().string();
}

std::string checked_geometry(const InferredManifest& field, const std::string& folder) {
  const std::string path = geometry_path(field, folder);
  // The message does not say why the file is unreadable. If it did, the author of a manifest could find out about
  // private files of the user who reads the manifest.
  const std::optional<std::string> hash = hash_regular_file(path);
  if (!hash)
    refuse_file(path, "is missing or cannot be read; expected the geometry file from which the textures were inferred");
  if (*hash != field.geometry_hash)
    throw Error(ErrorCode::kInput, path + ": is not the geometry file from which the textures were inferred (SHA-256 " +
                                       field.geometry_hash + ")");
  return path;
}

std::vector<std::string> inferred_field_files(const std::string& manifest_path) {
  const InferredManifest field = read_inferred_manifest(manifest_path);
  std::set<std::string> names;
  for (const InferredObject& object : field.objects) {
    if (object.layers.empty()) continue;
    for (const InferredLayer& layer : object.layers)
      for (const std::string& texture : layer.textures)
        if (!texture.empty()) names.insert(texture);
    for (const std::size_t first : object_poses(field, object).first_samples)
      names.insert(matrix_name(field.samples[first], object));
  }
  if (!field.geometry_file.empty()) names.insert(field.geometry_file);
  std::vector<std::string> files;
  const std::filesystem::path folder = std::filesystem::path(manifest_path).parent_path();
  for (const std::string& name : names) files.push_back((folder / name).lexically_normal().string());
  std::error_code unreadable;
  if (const auto report = folder / kInferenceReportName; std::filesystem::is_regular_file(report, unreadable))
    files.push_back(report.lexically_normal().string());
  return files;
}

}  // namespace multum
