// SPDX-License-Identifier: Apache-2.0
// In place of tools/multum/farm, where the CMake option MULTUM_FARM is off.
#include <nlohmann/json.hpp>

#include "tools/command_line/absent_commands.h"
#include "tools/multum/commands.h"

namespace multum {

void register_jobs() {}

void add_farm_commands(CLI::App& app, int*, CheckWords) {
  add_absent_commands(
      app, {"serve", "rescue", "submit", "list", "show", "tail", "wait", "cancel", "retry", "purge", "openjd"}, "farm",
      "MULTUM_FARM");
}

DoctorFindings service_findings(const std::string&) { return {}; }

nlohmann::ordered_json job_schemas() { return nlohmann::ordered_json::object(); }

}  // namespace multum
