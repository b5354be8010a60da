// SPDX-License-Identifier: Apache-2.0
// Replaces tools/multum/farm in a build without the CMake option MULTUM_FARM.
#include <nlohmann/json.hpp>

#include "tools/command_line/absent_commands.h"
#include "tools/multum/commands.h"

namespace multum {

void register_jobs() {}

void add_farm_commands(CLI::App& app, int*, CheckWords) {
  add_absent_commands(app, {"serve", "jobs", "openjd"}, "farm", "MULTUM_FARM");
}

DoctorFindings service_findings(const std::string&) { return {}; }

nlohmann::ordered_json job_schemas() { return nlohmann::ordered_json::object(); }

}  // namespace multum
