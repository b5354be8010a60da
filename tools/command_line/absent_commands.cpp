// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/absent_commands.h"

#include <fmt/format.h>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

void add_refused(CLI::App& app, const std::string& name, const std::string& message) {
  CLI::App* const command = app.add_subcommand(name, "");
  command->group("");
  command->set_help_flag();
  command->prefix_command();
  command->callback([message] { throw Error(ErrorCode::kUsage, message); });
}

}  // namespace

void add_absent_commands(CLI::App& app, const std::vector<std::string>& names, const std::string& part,
                         const std::string& option) {
  for (const std::string& name : names)
    add_refused(
        app, name,
        fmt::format("{}: this build of {} has no {}; expected a build with the CMake option -D{}=ON, as made by "
                    "tools/demo --all",
                    name, app.get_name(), part, option));
}

void add_moved_command(CLI::App& app, const std::string& name, const std::string& new_name) {
  add_refused(app, name,
              fmt::format("unknown command '{}', expected its new name: {} {}", name, app.get_name(), new_name));
}

}  // namespace multum
