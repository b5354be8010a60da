// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/command_text.h"

#include <filesystem>

namespace multum::bench {
namespace {

// Quotes a word for a shell, in single quotes unless all of its characters are plain.
std::string shell_quoted(const std::string& word) {
  constexpr char kPlain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:.,/%@^";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

}  // namespace

std::string command_text(const std::vector<std::string>& command) {
  std::string text;
  for (const std::string& argument : command)
    text += (text.empty() ? "" : " ") +
            shell_quoted(argument.starts_with('/') ? std::filesystem::path(argument).filename().string() : argument);
  return text;
}

}  // namespace multum::bench
