// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/usage_error.h"

#include <algorithm>
#include <sstream>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/nearest_name.h"
#include "host/foundation/base/shown_text.h"
#include "tools/command_line/chosen_command.h"

namespace multum {
namespace {

// The exit codes of docs/reference/exit_codes.md.
constexpr char kExitCodes[] =
    "\nExit codes:\n"
    "  0    done: the output is complete on disk\n"
    "  1    unexpected error: a bug of the program\n"
    "  2    wrong command line\n"
    "  3    unusable input file\n"
    "  4    missing device, driver, memory or disk space: try again later\n"
    "  5    failed check\n"
    "  130  cancelled by SIGINT or SIGTERM: run again\n";

}  // namespace

std::string exit_codes_text() { return kExitCodes; }

std::string parse_error_text(const CLI::App& app, const CLI::Error& error) {
  const std::vector<std::string> left = app.remaining(true);
  const auto unknown = std::find_if(left.begin(), left.end(), [](const std::string& word) {
    return word.size() > 1 && word.front() == '-' && word != "--";
  });
  // A misspelt required option causes a RequiredError.
  const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
  if ((code != CLI::ExitCodes::ExtrasError && code != CLI::ExitCodes::RequiredError) || unknown == left.end())
    return error.what();
  std::vector<std::string> names;
  for (const CLI::Option* const option : chosen_command(app).get_options())
    if (!option->get_group().empty() && !option->get_lnames().empty())  // options that the help shows
      names.push_back("--" + option->get_lnames().front());
  const std::string word = unknown->substr(0, unknown->find('='));
  const std::string nearest = nearest_name(word, names);
  return "unknown option '" + word + "'" + (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)");
}

namespace {

// Returns the usage line and the examples of a command's help. They are printed if a required option is missing.
std::string usage_and_examples(const CLI::App& command) {
  std::string text = command.get_formatter()->make_help(&command, command_words(command), CLI::AppFormatMode::Normal);
  const std::size_t usage = text.find("Usage: ");
  text = usage == std::string::npos ? "" : text.substr(usage, text.find('\n', usage) - usage + 1);
  std::istringstream description(command.get_description() + "\n" + command.get_footer());
  for (std::string line; std::getline(description, line);)
    if (line.starts_with("  multum")) text += line + "\n";
  return text;
}

}  // namespace

std::string usage_error(const CLI::App* app, const CLI::Error& error) {
  const CLI::App& command = chosen_command(*app);
  const auto is_shown = [](const CLI::App* one) { return !one->get_group().empty(); };  // true if the help shows it
  const std::vector<const CLI::App*> commands = command.get_subcommands(is_shown);
  const std::string words = command_words(command);
  const bool is_incomplete = static_cast<CLI::ExitCodes>(error.get_exit_code()) == CLI::ExitCodes::RequiredError;
  std::string text = app->get_name() + ": " + parse_error_text(*app, error);
  if (!commands.empty()) {
    const std::vector<std::string> unknown = command.remaining();
    text = words + (unknown.empty() ? ": no command given" : ": unknown command '" + unknown.front() + "'");
    text += ", expected one of:";
    for (const CLI::App* one : commands) text += " " + one->get_name();
    text += "\n";
  } else {
    text += "\n" + (is_incomplete && &command != app ? usage_and_examples(command) : "");
  }
  return text + "See '" + words + " --help'.\n";
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
