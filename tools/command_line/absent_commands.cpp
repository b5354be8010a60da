// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/absent_commands.h"

#include <fmt/format.h>

#include "host/foundation/base/error.h"

namespace multum {

void add_absent_commands(CLI::App& app, const std::vector<std::string>& names, const std::string& part,
                         const std::string& option) {
  for (const std::string& name : names) {
    CLI::App* const command = app.add_subcommand(name, "");
    command->group("");
    command->set_help_flag();
    command->prefix_command();
    command->callback([program = app.get_name(), name, part, option] {
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: this build of {} has no {}; expected one that was configured with "
                              "the CMake option -D{}=ON",
                              name, program, part, option));
    });
  }
}

}  // namespace multum
