// SPDX-License-Identifier: Apache-2.0
// Replaces fields/field_commands.cpp in a build without fields.
#include "host/foundation/base/error.h"
#include "tools/command_line/absent_commands.h"
#include "tools/multum/fields/field_commands.h"

namespace multum {

void add_field_commands(CLI::App& app, int* /*exit_code*/) {
  add_absent_commands(app, {"animation", "infer", "pack", "unpack", "player"}, "fields", "MULTUM_FIELDS");
}

std::optional<std::string> packed_field_info(const std::string& /*path*/) { return std::nullopt; }

std::optional<OrderedJson> packed_field_json(const std::string& /*path*/) { return std::nullopt; }

std::optional<std::vector<VerifyFinding>> packed_field_findings(const std::string& /*path*/) { return std::nullopt; }

std::vector<std::string> files_of_inference(const std::string& job) {
  throw Error(ErrorCode::kUsage, job +
                                     ": this build of multum has no fields; expected a build with "
                                     "the CMake option -DMULTUM_FIELDS=ON");
}

}  // namespace multum
