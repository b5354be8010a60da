// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/workers/work_order.h"

#include "host/foundation/base/path_text.h"

namespace multum {

nlohmann::json work_json(const WorkOrder& order) {
  return {{"run", order.job},
          {"attempt", order.attempt},
          {"type", order.type},
          {"parameters", order.parameters},
          {"share", order.share},
          {"output", text_of_path(order.output)},
          {"folder", text_of_path(order.folder)},
          {"log", text_of_path(order.log)},
          {"inputs", order.inputs},
          {"copy_from", text_of_path(order.copy_from)},
          {"copy_to", text_of_path(order.copy_to)}};
}

WorkOrder work_from(const nlohmann::json& json) {
  const auto path = [&](const char* key) { return path_of_text(json.at(key).get<std::string>()); };
  return {json.at("run"),    json.at("attempt"), json.at("type"), json.at("parameters"),
          json.at("share"),  path("output"),     path("folder"),  path("log"),
          json.at("inputs"), path("copy_from"),  path("copy_to")};
}

}  // namespace multum
