// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/usage_error.h"

#include <algorithm>
#include <sstream>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/nearest_name.h"
#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

// The table of docs/reference/exit_codes.md.
constexpr char kExitCodes[] =
    "\nExit codes:\n"
    "  0    done: the output is complete on disk\n"
    "  1    an unexpected error, a fault of the program\n"
    "  2    the command line is wrong\n"
    "  3    a file cannot be used\n"
    "  4    no device, no driver, no memory, no disk: worth trying again\n"
    "  5    a check failed\n"
    "  130  cancelled by SIGINT or SIGTERM: worth trying again\n";

}  // namespace

std::string parse_error_text(const CLI::App& app, const CLI::Error& error) {
  const std::vector<std::string> left = app.remaining(true);
  const auto unknown = std::find_if(left.begin(), left.end(), [](const std::string& word) {
    return word.size() > 1 && word.front() == '-' && word != "--";
  });
  // A required option that is misspelt is missing first of all.
  const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
  if ((code != CLI::ExitCodes::ExtrasError && code != CLI::ExitCodes::RequiredError) || unknown == left.end())
    return error.what();
  const std::vector<const CLI::App*> chosen = app.get_subcommands([](const CLI::App* one) { return one->parsed(); });
  std::vector<std::string> names;
  for (const CLI::Option* const option : (chosen.empty() ? app : *chosen.front()).get_options())
    if (!option->get_group().empty() && !option->get_lnames().empty())  // those in the help
      names.push_back("--" + option->get_lnames().front());
  const std::string word = unknown->substr(0, unknown->find('='));
  const std::string nearest = nearest_name(word, names);
  return "unknown option '" + word + "'" + (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)");
}

namespace {

// How the command is called, and the examples of its help: for whoever has left out what it needs.
std::string usage_and_examples(const CLI::App& command, const std::string& program) {
  std::string text = command.get_formatter()->make_help(&command, program, CLI::AppFormatMode::Normal);
  const std::size_t usage = text.find("Usage: ");
  text = usage == std::string::npos ? "" : text.substr(usage, text.find('\n', usage) - usage + 1);
  std::istringstream description(command.get_description());
  for (std::string line; std::getline(description, line);)
    if (line.starts_with("  multum")) text += line + "\n";
  return text;
}

}  // namespace

std::string usage_error(const CLI::App* app, const CLI::Error& error) {
  const std::vector<CLI::App*> chosen = app->get_subcommands();
  const auto is_shown = [](const CLI::App* command) { return !command->get_group().empty(); };  // in the help
  const std::vector<const CLI::App*> commands = app->get_subcommands(is_shown);
  std::string text = app->get_name() + ": " + parse_error_text(*app, error);
  if (chosen.empty() && !commands.empty()) {
    const std::vector<std::string> unknown = app->remaining();
    text = app->get_name() + (unknown.empty() ? ": no command given" : ": unknown command '" + unknown.front() + "'");
    text += ", expected one of:";
    for (const CLI::App* command : commands) text += " " + command->get_name();
  }
  const std::string program = app->get_name() + (chosen.empty() ? "" : " " + chosen.front()->get_name());
  const bool is_incomplete = static_cast<CLI::ExitCodes>(error.get_exit_code()) == CLI::ExitCodes::RequiredError;
  if (is_incomplete && !chosen.empty()) text += "\n" + usage_and_examples(*chosen.front(), program);
  else text += "\n";
  return text + "See '" + program + " --help'.\n";
}

int print_parse_error(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream out, err;
  const int code = app.exit(error, out, err);
  const bool is_help = dynamic_cast<const CLI::CallForHelp*>(&error) != nullptr ||
                       dynamic_cast<const CLI::CallForAllHelp*>(&error) != nullptr;
  write_shown(stdout, out.str() + (is_help ? kExitCodes : ""));
  write_shown(stderr, err.str());
  return code == 0 ? 0 : exit_code(ErrorCode::kUsage);
}

}  // namespace multum
