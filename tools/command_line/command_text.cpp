// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/command_text.h"

#include <fmt/format.h>

#include <regex>

#include "tools/command_line/chosen_command.h"

namespace multum {
namespace {

// Converts "INT in [1, 8]" (from parameters) and "INT:INT in [1 - 8]" (from CLI11) to "1 to 8". Omits names of plain
// types.
std::string words_of_type(const std::string& type) {
  static const std::regex range(
      "(?:N|INT|UINT|FLOAT)(?::(?:INT|UINT|FLOAT))? in ([\\[(])([^ ,]+)(?:,| -) ([^\\])]+)\\](.*)");
  static const std::regex bound("(?:INT|FLOAT) (>=?) ([^ ]+)(.*)");
  std::smatch found;
  if (std::regex_match(type, found, range)) {
    const std::string high = fmt::format("{:.15g}", std::stod(found[3].str()));  // avoids 1e+06
    const std::string low = found[2].str();
    return (found[1] == "(" ? "above " + low + ", at most " : low + " to ") + high + found[4].str();
  }
  if (std::regex_match(type, found, bound))
    return (found[1] == ">" ? "above " : "at least ") + found[2].str() + found[3].str();
  if (type.find("NONNEGATIVE") != std::string::npos) return "at least 0";
  if (type.find("POSITIVE") != std::string::npos) return "above 0";
  if (type.find("SIZE") != std::string::npos) return "SIZE";
  if (type == "TEXT" || type == "[TEXT,...]") return "";
  if (type == "INT" || type == "UINT") return "integer";
  if (type == "FLOAT") return "number";
  static const std::regex number("(?:INT|UINT|FLOAT)( .*)");
  if (std::regex_match(type, found, number)) return "number" + found[1].str();
  return type.starts_with("TEXT:") ? type.substr(5) : type;
}

std::vector<std::string> choices_of_type(const std::string& type) {
  const std::size_t open = type.find('{');
  if (open == std::string::npos || !type.ends_with('}')) return {};
  return CLI::detail::split(type.substr(open + 1, type.size() - open - 2), ',');
}

OptionText option_text(const CLI::Option& option) {
  OptionText text;
  if (!option.get_snames().empty()) text.short_name = "-" + option.get_snames().front();
  if (!option.get_lnames().empty()) text.long_name = "--" + option.get_lnames().front();
  if (option.get_positional()) text.positional = option.get_name(true, false);
  text.help = option.get_description();
  text.group = option.get_group();
  text.is_flag = option.get_items_expected_max() == 0;
  text.is_required = option.get_required();
  text.is_repeatable = option.get_expected_max() >= CLI::detail::expected_max_vector_size;
  if (text.is_flag) return text;
  text.default_text = option.get_default_str();
  text.choices = choices_of_type(option.get_type_name());
  if (text.choices.empty()) text.value = words_of_type(option.get_type_name());
  return text;
}

}  // namespace

std::string OptionText::values() const {
  std::string text = value;
  for (std::size_t i = 0; i < choices.size(); ++i)
    text += (i == 0 ? "" : i + 1 == choices.size() ? " or " : ", ") + choices[i];
  return text;
}

std::string CommandText::usage() const {
  std::string text = words;
  if (!options.empty()) text += " [OPTION...]";
  for (const OptionText& option : options) {
    if (option.positional.empty()) continue;
    const std::string word = option.positional + (option.is_repeatable ? "..." : "");
    text += option.is_required ? " " + word : " [" + word + "]";
  }
  if (!commands.empty()) text += needs_command ? " COMMAND" : " [COMMAND]";
  return text;
}

CommandText describe(const CLI::App& app) {
  CommandText text;
  text.words = command_words(app);
  text.name = app.get_name();
  text.group = app.get_group();
  text.help = app.get_description();
  text.examples = app.get_footer();
  text.needs_command = app.get_require_subcommand_min() > 0;
  for (const bool positional : {true, false})
    for (const CLI::Option* option : app.get_options())
      if (!option->get_group().empty() && option->get_positional() == positional)
        text.options.push_back(option_text(*option));
  for (const CLI::App* command : app.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); }))
    text.commands.push_back(describe(*command));
  return text;
}

}  // namespace multum
