// SPDX-License-Identifier: Apache-2.0
// Implements multum-view each, which runs several command lines in one process. Loading a GL driver takes tens of
// milliseconds, which is longer than drawing a small map.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"
#include "tools/multum_view/command_line.h"
#include "tools/multum_view/modes.h"

namespace multum {
namespace {

using CommandLines = std::vector<std::vector<std::string>>;

CommandLines read_command_lines(const std::string& path) {
  const std::optional<std::string> text = json_of_file(path);
  if (!text) throw Error(ErrorCode::kInput, path + ": cannot be read");
  try {
    return nlohmann::json::parse(*text).get<CommandLines>();
  } catch (const nlohmann::json::exception&) {
    throw Error(ErrorCode::kInput, path +
                                       ": expected a JSON array of command lines, each an array of strings, such as "
                                       "[[\"bricks.ndf.exr\", \"-o\", \"bricks.png\"]]");
  }
}

}  // namespace

void add_each_options(CLI::App& app, EachOptions& options) {
  app.add_option("file", options.file, "JSON array of command lines, each an array of words")->required();
}

int run_each(const EachOptions& options) {
  const CommandLines lines = read_command_lines(options.file);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!lines[i].empty() && lines[i].front() == "each")
      throw Error(ErrorCode::kInput, fmt::format("{}: command line {}: found 'each', expected another subcommand or a "
                                                 "baked map",
                                                 options.file, i + 1));
    std::vector<std::string> words = paths_of_texts(lines[i]);
    words.insert(words.begin(), "multum-view");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    if (const int code = run_view_command(static_cast<int>(arguments.size()), arguments.data()); code != 0) return code;
  }
  return 0;
}

}  // namespace multum
