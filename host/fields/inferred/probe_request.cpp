// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inferred/probe_request.h"

#include "host/fields/inferred/matrix_json.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

// Throws Error. The caller adds the file's name.
ProbeRequest request_from(const nlohmann::json& json) {
  if (json_int(json, "multumProbeRequest") != 1)
    throw Error(ErrorCode::kInput, "is a probe request of another version, expected version 1");
  ProbeRequest request;
  request.geometry_file = path_of_text(json.at("geometry").get<std::string>());
  request.uv_set = json_int(json, "uvSet");
  request.width = json_int(json, "width");
  request.height = json_int(json, "height");
  request.supersampling = json_int(json, "supersampling");
  request.view = json.at("view").get<std::string>();
  request.world_to_clip = matrix_from_json(json.at("worldToClip"));
  for (const auto& [name, matrix] : json.at("objectToWorld").items())
    request.object_to_world[name] = matrix_from_json(matrix);
  for (const nlohmann::json& task : json.at("tasks"))
    request.tasks.push_back({task.at("object").get<std::string>(), task.at("mapping").get<TextureMapping>(),
                             anisotropy_from_json(task.at("anisotropy")), task.at("hasMips").get<bool>(),
                             path_of_text(task.at("output").get<std::string>()), task.at("key").get<std::string>()});
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
                     {"output", text_of_path(task.output)},
                     {"key", task.key}});
  nlohmann::json moved = nlohmann::json::object();
  for (const auto& [name, matrix] : request.object_to_world) moved[name] = matrix_json(matrix);
  const nlohmann::json json = {{"multumProbeRequest", 1},  {"geometry", text_of_path(request.geometry_file)},
                               {"uvSet", request.uv_set},  {"width", request.width},
                               {"height", request.height}, {"supersampling", request.supersampling},
                               {"view", request.view},     {"worldToClip", matrix_json(request.world_to_clip)},
                               {"objectToWorld", moved},   {"tasks", tasks}};
  write_text_file(path, json_text(json, 1) + "\n");
}

ProbeRequest read_probe_request(const std::string& path) {
  const std::optional<std::string> text = json_of_file(path);
  if (!text) throw Error(ErrorCode::kInput, path + ": cannot be read");
  try {
    return request_from(nlohmann::json::parse(*text));
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorCode::kInput, path + ": is not a probe request: " + error.what());
  }
}

}  // namespace multum
