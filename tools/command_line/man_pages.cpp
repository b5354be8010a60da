// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/man_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "tools/command_line/usage_error.h"

namespace multum {
namespace {

// Escapes backslashes and hyphens. A line of text must not begin with a dot or an apostrophe, because roff would treat
// the line as a request.
std::string escaped(const std::string& text) {
  std::string result;
  bool at_start = true;
  for (const char c : text) {
    if (at_start && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') result += "\\e";
    else if (c == '-') result += "\\-";
    else result += c;
    at_start = c == '\n';
  }
  return result;
}

// Keeps the line breaks and spaces of a text.
std::string verbatim(const std::string& text) { return ".nf\n" + escaped(text) + "\n.fi\n"; }

std::string page_name(const CommandText& command) {
  std::string name = command.words;
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

// Returns the first paragraph of a help text as one line.
std::string summary(const CommandText& command) {
  std::string text = command.help.substr(0, command.help.find("\n\n"));
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string rest_of_help(const CommandText& command) {
  const std::size_t end = command.help.find("\n\n");
  return end == std::string::npos ? "" : command.help.substr(end + 2);
}

std::string option_entry(const OptionText& option) {
  std::string head;
  for (const std::string& name : {option.short_name, option.long_name})
    if (!name.empty()) head += (head.empty() ? "\\fB" : ", \\fB") + escaped(name) + "\\fR";
  if (head.empty()) head = "\\fI" + escaped(option.positional) + "\\fR";
  else if (!option.is_flag) head += " \\fI" + escaped(option.values()) + "\\fR";
  std::string help = option.help;
  if (!option.default_text.empty()) help += "; default: " + option.default_text;
  if (option.is_required) help += "; required";
  return ".TP\n" + head + "\n" + escaped(help) + "\n";
}

std::string option_entries(const CommandText& command) {
  std::string text;
  std::vector<std::string> groups;
  for (const OptionText& option : command.options)
    if (std::find(groups.begin(), groups.end(), option.group) == groups.end()) groups.push_back(option.group);
  for (const std::string& group : groups) {
    if (groups.size() > 1) text += ".SS " + escaped(group) + "\n";
    for (const OptionText& option : command.options)
      if (option.group == group) text += option_entry(option);
  }
  return text;
}

// Describes the subcommands of a command and their options.
std::string subcommands(const CommandText& command) {
  std::string text;
  for (const CommandText& one : command.commands) {
    text +=
        fmt::format(".SH {}\n{}\n.PP\n\\fB{}\\fR\n", escaped(one.words), escaped(summary(one)), escaped(one.usage()));
    text += option_entries(one) + subcommands(one);
  }
  return text;
}

std::string page(const CommandText& command, const std::string& listed, const std::string& version) {
  std::string title = page_name(command);
  std::transform(title.begin(), title.end(), title.begin(), [](char c) { return c >= 'a' && c <= 'z' ? c - 32 : c; });
  std::string text = fmt::format(".TH {} 1 \"\" \"multum {}\" \"multum\"\n.SH NAME\n{} \\- {}\n", escaped(title),
                                 version, escaped(page_name(command)), escaped(summary(command)));
  text += ".SH SYNOPSIS\n.B " + escaped(command.usage()) + "\n";
  if (const std::string more = rest_of_help(command); !more.empty()) text += ".SH DESCRIPTION\n" + verbatim(more);
  if (!command.options.empty()) text += ".SH OPTIONS\n" + option_entries(command);
  text += listed;
  if (!command.examples.empty()) text += ".SH NOTES\n" + verbatim(command.examples);
  std::istringstream codes(exit_codes_text());
  std::string table;
  for (std::string line; std::getline(codes, line);)
    if (line.starts_with("  ")) table += line + "\n";
  return text + ".SH EXIT STATUS\n" + verbatim(table);
}

}  // namespace

std::map<std::string, std::string> man_pages(const CommandText& program, const std::string& version) {
  std::map<std::string, std::string> pages;
  std::string listed, group;
  for (const CommandText& command : program.commands) {
    if (command.group != group) listed += ".SS " + escaped(command.group) + "\n";
    group = command.group;
    listed += fmt::format(".TP\n\\fB{}\\fR(1)\n{}\n", escaped(page_name(command)), escaped(summary(command)));
    pages[page_name(command) + ".1"] = page(command, subcommands(command), version);
  }
  pages[page_name(program) + ".1"] = page(program, listed.empty() ? "" : ".SH COMMANDS\n" + listed, version);
  return pages;
}

}  // namespace multum
