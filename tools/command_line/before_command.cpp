// SPDX-License-Identifier: Apache-2.0
// Runs before a command does anything. Refuses names that are too long for any file system, and creates output folders.
#include "tools/command_line/before_command.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <filesystem>
#include <iterator>
#include <set>
#include <string>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/messages/option_words.h"
#include "tools/command_line/chosen_command.h"

namespace multum {
namespace {

// The options whose values are not file names, such as a job's label, a curve through parameters, or a device.
constexpr const char* kTexts[] = {"label", "name", "path", "device"};

// The options that name a file or folder to write, or a prefix of file names.
constexpr const char* kOutputs[] = {"output",   "report",   "page",    "player",         "junit",        "summary",
                                    "markdown", "pictures", "shaders", "keep-reference", "debug-picture"};

// JSON texts and addresses are also not file names.
bool is_name(const CLI::Option& option, const std::string& value) {
  return std::none_of(std::begin(kTexts), std::end(kTexts),
                      [&](const char* name) { return option.check_lname(name); }) &&
         value.find_first_of("{\n") == std::string::npos && value.find("://") == std::string::npos;
}

void check(const CLI::Option& option, const std::string& value) {
  struct stat status = {};
  if (value.size() <= NAME_MAX || !is_name(option, value)) return;
  if (::lstat(value.c_str(), &status) == 0 || errno != ENAMETOOLONG) return;
  std::size_t longest = 0;
  for (const std::filesystem::path& part : std::filesystem::path(value))
    longest = std::max(longest, part.native().size());
  const bool is_part = longest > NAME_MAX;
  throw Error(ErrorCode::kUsage, fmt::format("{} {}: the name is too long: {} has {} bytes, expected at most {}",
                                             option.get_name(), value, is_part ? "a part" : "a path",
                                             is_part ? longest : value.size(), is_part ? NAME_MAX : PATH_MAX - 1));
}

void check_values(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options())
    for (const std::string& value : option->results()) check(*option, value);
  for (const CLI::App* command : app.get_subcommands([](const CLI::App* one) { return one->parsed(); }))
    check_values(*command);
}

// NewFolders removes folders that are still empty at the end, so a command that fails leaves no folder.
void make_output_folders(const CLI::App& command) {
  if (command.get_option_no_throw("--server") != nullptr) return;  // with --server, the output is on the service's disk
  for (const CLI::Option* option : command.get_options()) {
    const bool is_output = std::any_of(std::begin(kOutputs), std::end(kOutputs),
                                       [&](const char* name) { return option->check_lname(name); });
    if (!is_output) continue;
    for (const std::string& path : option->results()) {
      const std::filesystem::path folder = std::filesystem::path(path).parent_path();
      if (!folder.empty()) make_folder(folder.string());
    }
  }
}

std::set<std::string> option_names(const CLI::App& command) {
  std::set<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (std::string name : option->get_lnames()) {
      std::replace(name.begin(), name.end(), '-', '_');
      names.insert(name);
    }
  return names;
}

}  // namespace

void prepare_commands(CLI::App& app) {
  app.parse_complete_callback([&app] {
    check_values(app);
    set_option_words(option_names(chosen_command(app)));
    make_output_folders(chosen_command(app));
  });
}

}  // namespace multum
