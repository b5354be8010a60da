// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/usage_error.h"

#include <sstream>
#include <vector>

#include "host/base/error.h"
#include "host/base/shown_text.h"

namespace multum {

std::string usage_error(const CLI::App* app, const CLI::Error& error) {
  const std::vector<CLI::App*> chosen = app->get_subcommands();
  const auto is_shown = [](const CLI::App* command) { return !command->get_group().empty(); };  // in the help
  const std::vector<const CLI::App*> commands = app->get_subcommands(is_shown);
  std::string text = app->get_name() + ": " + error.what();
  if (chosen.empty() && !commands.empty()) {
    const std::vector<std::string> unknown = app->remaining();
    text = app->get_name() + (unknown.empty() ? ": no command given" : ": unknown command '" + unknown.front() + "'");
    text += ", expected one of:";
    for (const CLI::App* command : commands) text += " " + command->get_name();
  }
  const std::string program = app->get_name() + (chosen.empty() ? "" : " " + chosen.front()->get_name());
  return text + "\nSee '" + program + " --help'.\n";
}

int print_parse_error(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream out, err;
  const int code = app.exit(error, out, err);
  write_shown(stdout, out.str());
  write_shown(stderr, err.str());
  return code == 0 ? 0 : exit_code(ErrorCode::kUsage);
}

}  // namespace multum
