// SPDX-License-Identifier: Apache-2.0
// In the place of fields/field_commands.cpp where fields are not built.
#include "host/foundation/base/error.h"
#include "tools/multum/fields/field_commands.h"

namespace multum {
namespace {

[[noreturn]] void refuse(const std::string& command) {
  throw Error(ErrorCode::kUsage, command + ": this multum was built without fields (CMake option MULTUM_FIELDS)");
}

}  // namespace

// Their names are there, not in the help, so that whoever calls them reads why they do nothing.
void add_field_commands(CLI::App& app, int* /*exit_code*/) {
  for (const std::string name : {"animation", "infer", "pack", "unpack", "player"}) {
    CLI::App* const command = app.add_subcommand(name, "");
    command->group("");
    command->allow_extras();
    command->callback([name] { refuse(name); });
  }
}

std::optional<std::string> packed_field_info(const std::string& /*path*/) { return std::nullopt; }

std::optional<std::vector<VerifyFinding>> packed_field_findings(const std::string& /*path*/) { return std::nullopt; }

std::vector<std::string> files_of_inference(const std::string& /*job*/) { refuse("infer"); }

}  // namespace multum
