// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/messages/option_words.h"

#include <algorithm>
#include <utility>

namespace multum {
namespace {

constexpr char kBegin = '\x02', kEnd = '\x03';  // characters that no message contains

struct Words {
  std::optional<std::set<std::string>> options;
  std::set<std::string> keys;
};

Words& words_of_command() {
  static Words words;
  return words;
}

std::string on_command_line(std::string name, const std::string& value) {
  std::replace(name.begin(), name.end(), '_', '-');
  return "--" + name + (value.empty() ? "" : " " + value);
}

// Formats a key as in TOML. Flags are written as true, numbers without quotes, and all other values with quotes.
std::string as_key(const std::string& name, const std::string& value) {
  if (value.empty()) return name + " = true";
  const bool is_number = value.find_first_not_of("+-.0123456789eN") == std::string::npos;
  return name + " = " + (is_number ? value : '"' + value + '"');
}

}  // namespace

void set_option_words(std::optional<std::set<std::string>> names) { words_of_command() = {std::move(names), {}}; }

void add_key_words(const std::vector<std::string>& names) {
  words_of_command().keys.insert(names.begin(), names.end());
}

std::optional<std::string> option_text(const std::string& name, const std::string& value) {
  const Words& words = words_of_command();
  if (words.keys.contains(name)) return as_key(name, value);
  if (words.options && !words.options->contains(name)) return std::nullopt;
  return on_command_line(name, value);
}

std::string advice(const std::string& text) {
  std::string result;
  std::size_t done = 0;
  for (std::size_t open = text.find('<'); open != std::string::npos; open = text.find('<', done)) {
    const std::size_t close = text.find('>', open);
    if (close == std::string::npos) break;
    const std::string inner = text.substr(open + 1, close - open - 1);
    const std::size_t space = inner.find(' ');
    const std::optional<std::string> option =
        option_text(inner.substr(0, space), space == std::string::npos ? "" : inner.substr(space + 1));
    if (!option) return "";
    result += text.substr(done, open - done) + *option;
    done = close + 1;
  }
  return kBegin + result + text.substr(done) + kEnd;
}

std::string names_as_advice(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    const bool is_key = words_of_command().keys.contains(name);
    text += (text.empty() ? ": " : ", ") + (is_key ? name : on_command_line(name, ""));
  }
  return kBegin + text + kEnd;
}

std::string with_advice(std::string message) {
  std::erase_if(message, [](char c) { return c == kBegin || c == kEnd; });
  return message;
}

std::vector<std::string> with_advice(std::vector<std::string> messages) {
  for (std::string& message : messages) message = with_advice(std::move(message));
  return messages;
}

std::string without_advice(const std::string& message) {
  std::string text;
  bool is_advice = false;
  for (const char c : message) {
    if (c == kBegin || c == kEnd) is_advice = c == kBegin;
    else if (!is_advice) text += c;
  }
  return text;
}

}  // namespace multum
