// SPDX-License-Identifier: Apache-2.0
#include "host/asset/inferred/probe_request.h"

#include <fstream>

#include "host/asset/inferred/matrix_json.h"
#include "host/base/error.h"
#include "host/base/files/atomic_file.h"

namespace multum {
namespace {

// Throws Error without the file's name, which the caller knows.
ProbeRequest request_from(const nlohmann::json& json) {
  if (json.at("multumProbeRequest").get<int>() != 1)
    throw Error(ErrorCode::kInput, "is a probe request of another version, expected 1");
  ProbeRequest request;
  request.geometry_file = json.at("geometry").get<std::string>();
  request.uv_set = json.at("uvSet").get<int>();
  request.width = json.at("width").get<int>();
  request.height = json.at("height").get<int>();
  request.supersampling = json.at("supersampling").get<int>();
  request.view = json.at("view").get<std::string>();
  request.world_to_clip = matrix_from_json(json.at("worldToClip"));
  for (const auto& [name, matrix] : json.at("objectToWorld").items())
    request.object_to_world[name] = matrix_from_json(matrix);
  for (const nlohmann::json& task : json.at("tasks"))
    request.tasks.push_back({task.at("object").get<std::string>(), task.at("mapping").get<TextureMapping>(),
                             anisotropy_from_json(task.at("anisotropy")), task.at("hasMips").get<bool>(),
                             task.at("output").get<std::string>(), task.at("key").get<std::string>()});
  check_picture_size(request.width, request.height, request.supersampling);
  return request;
}

}  // namespace

void write_probe_request(const ProbeRequest& request, const std::string& path) {
  nlohmann::json tasks = nlohmann::json::array();
  for (const ProbeTask& task : request.tasks)
    tasks.push_back({{"object", task.object},
                     {"mapping", task.mapping},
                     {"anisotropy", task.anisotropy},
                     {"hasMips", task.has_mips},
                     {"output", task.output},
                     {"key", task.key}});
  nlohmann::json moved = nlohmann::json::object();
  for (const auto& [name, matrix] : request.object_to_world) moved[name] = matrix_json(matrix);
  const nlohmann::json json = {{"multumProbeRequest", 1},  {"geometry", request.geometry_file},
                               {"uvSet", request.uv_set},  {"width", request.width},
                               {"height", request.height}, {"supersampling", request.supersampling},
                               {"view", request.view},     {"worldToClip", matrix_json(request.world_to_clip)},
                               {"objectToWorld", moved},   {"tasks", tasks}};
  write_text_file(path, json.dump(1) + "\n");
}

ProbeRequest read_probe_request(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error(ErrorCode::kInput, path + ": cannot be read");
  try {
    return request_from(nlohmann::json::parse(file));
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorCode::kInput, path + ": is not a probe request: " + error.what());
  }
}

}  // namespace multum
