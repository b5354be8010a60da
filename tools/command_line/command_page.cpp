// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/command_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_tables.h"

namespace multum {
namespace {

// Options that at least this many commands share are listed in a section of their own.
constexpr std::size_t kManyCommands = 4;
constexpr char kSharedHeading[] = "Options of many commands";

constexpr char kHead[] =
    "# Commands\n\n"
    "This page lists the options of `multum` and `multum-view`, and the keys of manifests, scenes and jobs. The\n"
    "programs print the same texts with `--help`. `tools/parameter_documents` writes this page; do not edit it.\n\n"
    "- Sizes are in texels unless a unit is named. Directions and positions are `x,y,z`.\n"
    "- The column *keys* shows where a parameter is also a key: *m* in `[defaults]` and `[[map]]` of a\n"
    "  [manifest](manifests.md), *s* in `[[map]]` of a [scene](scenes.md), *j* in the parameters of a\n"
    "  [job](service.md). The key of `--first-level` is `first_level`.\n"
    "- The column *values* ends with the default in parentheses. SIZE is a number of bytes, such as 800M or 2G.\n"
    "- The column *hashed* names the key in `multum:settings` of a [baked file](file_format.md). Parameters\n"
    "  without such a key do not change the content.\n"
    "- Commands return these [exit codes](exit_codes.md).\n";

// Formats text for a table cell. Option names become code, page paths become links, and Markdown characters are
// escaped.
std::string cell(const std::string& text) {
  std::string result;
  bool is_code = false;
  for (const char c : text) {
    if (c == '`') is_code = !is_code;
    if (c == '|') result += "\\|";
    else if (!is_code && (c == '<' || c == '*' || c == '[')) result += std::string("\\") + c;
    else result += c;
  }
  static const std::regex option("(^|[^`\\w-])(--[a-z][a-z-]*)");
  result = std::regex_replace(result, option, "$1`$2`");
  static const std::regex page("docs/reference/([a-z_]+)\\.md"), other("docs/([a-z-]+)/([A-Za-z_]+)\\.md");
  result = std::regex_replace(result, page, "[$1]($1.md)");
  return std::regex_replace(result, other, "[$2](../$1/$2.md)");
}

std::string sentence(std::string text) {
  if (text.empty()) return text;
  if (text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return cell(text) + (text.ends_with('.') ? "" : ".");
}

std::string anchor(std::string heading) {
  std::replace(heading.begin(), heading.end(), ' ', '-');
  return heading;
}

std::string link(const CommandText& command) {
  return fmt::format("[`{}`](#{})", command.words, anchor(command.words));
}

std::string code(const std::string& text) { return "`" + text + "`"; }

std::string key_of(const OptionText& option) {
  std::string key = option.long_name.empty() ? option.positional : option.long_name.substr(2);
  std::replace(key.begin(), key.end(), '-', '_');
  return key;
}

std::string keys_text(const Parameter& row) {
  std::string text;
  for (const auto& [surface, letter] :
       {std::pair{kInManifest, "m"}, std::pair{kInScene, "s"}, std::pair{kInService, "j"}})
    if (row.is_on(surface)) text += letter;
  return text;
}

bool has_keys(const ParameterTable& table) {
  return std::any_of(table.rows().begin(), table.rows().end(),
                     [](const Parameter& row) { return !keys_text(row).empty(); });
}

bool has_hashes(const ParameterTable& table) {
  return std::any_of(table.rows().begin(), table.rows().end(),
                     [](const Parameter& row) { return !row.hashed_as.empty() && !keys_text(row).empty(); });
}

// Rows of kFitGroup need no note, because the heading of the group states the scope.
std::string scope_note(const Parameter& row) {
  switch (row.scope) {
    case ParameterScope::kAll: return "";
    case ParameterScope::kLobes: return row.group == kFitGroup ? "" : "; only for vmf and gmm";
    case ParameterScope::kHarmonics: return "; only for sh";
  }
  return "";
}

// The columns of a table, which are either only options, or options with their keys.
struct Columns {
  const ParameterTable* table = nullptr;  // if null, the table shows no keys
  bool hashes = false;

  std::string head() const {
    if (table == nullptr) return "|option|values|meaning|\n|---|---|---|\n";
    return hashes ? "|option|values|keys|hashed|meaning|\n|---|---|---|---|---|\n"
                  : "|option|values|keys|meaning|\n|---|---|---|---|\n";
  }
  std::string row(const std::string& name, const std::string& values, const Parameter* parameter,
                  const std::string& help) const {
    std::string text = "|" + name + "|" + values + "|";
    if (table != nullptr) text += (parameter != nullptr ? keys_text(*parameter) : "") + "|";
    if (hashes) text += (parameter != nullptr && !parameter->hashed_as.empty() ? code(parameter->hashed_as) : "") + "|";
    return text + help + "|\n";
  }
};

Columns columns_of(const ParameterTable* table) {
  if (table == nullptr || !has_keys(*table)) return {};
  return {table, has_hashes(*table)};
}

bool has_word(const std::string& text, const std::string& word) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const auto is_part = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
    };
    const bool begins = at == 0 || !is_part(text[at - 1]);
    if (begins && (at + word.size() == text.size() || !is_part(text[at + word.size()]))) return true;
  }
  return false;
}

// Returns the values and then the default, as in "1 to 8 (`4`)". Choices that the help text explains are not listed
// again.
std::string values_of(const OptionText& option) {
  const bool are_explained = std::all_of(option.choices.begin(), option.choices.end(),
                                         [&](const std::string& choice) { return has_word(option.help, choice); });
  std::string text = option.choices.empty() ? cell(option.value) : "";
  for (const std::string& choice : option.choices)
    if (!are_explained) text += (text.empty() ? "" : ", ") + code(choice);
  const std::string& value = option.default_text;
  if (!value.empty())
    text += (text.empty() ? "(" : " (") + (value.find(' ') == std::string::npos ? code(value) : cell(value)) + ")";
  if (option.is_required) text += text.empty() ? "required" : "; required";
  return text;
}

std::string option_row(const OptionText& option, const Columns& columns) {
  const Parameter* const parameter = columns.table != nullptr ? columns.table->find(key_of(option)) : nullptr;
  std::string name;
  for (const std::string& one : {option.positional, option.short_name, option.long_name})
    if (!one.empty()) name += (name.empty() ? "" : " ") + code(one);
  return columns.row(name, values_of(option), parameter,
                     cell(option.help) + (parameter != nullptr ? scope_note(*parameter) : ""));
}

// Returns the values of a key in the form of values_of().
std::string key_values(const Parameter& row) {
  std::string text = row.kind == ParameterKind::kFile   ? "FILE"
                     : row.kind == ParameterKind::kText ? ""
                                                        : expected_text(row);
  for (const char* kind : {"an integer from ", "a number from ", "a number "})
    if (text.starts_with(kind)) text = text.substr(std::string(kind).size());
  if (!row.default_text.empty()) text += (text.empty() ? "(" : " (") + row.default_text + ")";
  return cell(text);
}

// Returns the rows for parameters that are not options, which are keys of files and jobs, and settings that are only
// hashed.
std::string key_rows(const Columns& columns, const std::set<std::string>& shown = {}) {
  std::string text;
  for (const Parameter& row : columns.table->rows())
    if (!row.is_on(kOnCommandLine) && !shown.contains(row.name))
      text += columns.row(code(row.name), key_values(row), &row,
                          cell(row.help) + scope_note(row) + (row.surfaces == 0 ? "; fixed" : ""));
  return text;
}

std::string heading_of(const std::string& group) { return group == kFitGroup ? group + " (vmf and gmm)" : group; }

// Positionals and --output have a different meaning for each command, so each command describes them itself.
bool is_own(const OptionText& option) { return option.long_name.empty() || option.long_name == "--output"; }

bool is_help(const OptionText& option) { return option.long_name == "--help"; }

// Two commands share an option if all its texts are the same.
std::string identity(const OptionText& option) {
  return fmt::format("{}\n{}\n{}\n{}\n{}\n{}", option.short_name, option.name(), option.values(), option.default_text,
                     option.is_required, option.help);
}

bool is_submit(const CommandText& command) { return command.words.ends_with(" jobs submit"); }

// Collects commands in the order of the page. Job types belong to the section of `submit`.
void collect(const CommandText& command, std::vector<const CommandText*>& all) {
  all.push_back(&command);
  if (is_submit(command)) return;
  for (const CommandText& one : command.commands) collect(one, all);
}

std::string names_text(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + code(name);
  return text;
}

class Page {
 public:
  explicit Page(const CommandText& program) : program_(program) {
    collect(program, commands_);
    std::map<std::string, std::size_t> counts;
    for (const CommandText* command : commands_)
      for (const OptionText& option : command->options)
        if (!is_own(option)) ++counts[identity(option)];
    // A program that can run without a subcommand describes all of its options in its own section.
    for (const auto& [key, count] : counts)
      if (count >= kManyCommands && program.needs_command) shared_.insert(key);
  }

  std::string text() {
    std::string page = overview();
    if (!shared_.empty()) page += shared_section();
    for (const CommandText* command : commands_)
      if (command != &program_ || !program_.needs_command) page += section(*command);
    if (program_.name == "multum") page += scene_section();
    return page;
  }

 private:
  std::string overview() const {
    std::string text = "\n## Commands of " + program_.name + "\n\n";
    std::string group = "";
    for (const CommandText& one : program_.commands) {
      if (one.group != group) text += (group.empty() ? "- " : "\n- ") + one.group + ":";
      group = one.group;
      text += fmt::format(" [`{}`](#{})", one.name, anchor(one.words));
    }
    return text + "\n";
  }

  std::string shared_section() {
    const Columns columns = columns_of(program_.name == "multum" ? find_parameter_table("bake") : nullptr);
    std::string text = std::string("\n## ") + kSharedHeading + "\n";
    std::set<std::string> done;
    std::vector<std::string> groups;
    std::map<std::string, std::string> rows;
    for (const CommandText* command : commands_)
      for (const OptionText& option : command->options) {
        if (!shared_.contains(identity(option)) || is_help(option)) continue;
        if (!done.insert(identity(option)).second) continue;
        if (rows[option.group].empty()) groups.push_back(option.group);
        rows[option.group] += option_row(option, columns);
        ++shared_counts_[option.group];
      }
    for (const std::string& group : groups)
      text += (group == "Options" ? "\n" : "\n**" + group + "**\n\n") + columns.head() + rows[group];
    return text;
  }

  // multum-view has options of multum bake for reading maps. They are described in the part about multum.
  bool is_reading_option(const OptionText& option) const {
    return program_.name != "multum" && option.group == kSourceGroup;
  }

  // Names the options that another section describes.
  std::string named_elsewhere(const CommandText& command) const {
    std::map<std::string, std::vector<std::string>> shared;  // by group
    std::map<const CommandText*, std::vector<std::string>> others;
    for (const OptionText& option : command.options) {
      if (is_help(option)) continue;
      const bool is_in_main = is_reading_option(option) && &command != &program_;
      if (is_in_main) others[&program_].push_back(option.name());
      else if (shared_.contains(identity(option))) shared[option.group].push_back(option.name());
      else if (const CommandText* const owner = owner_of(option); owner != nullptr && owner != &command)
        others[owner].push_back(option.name());
    }
    std::string text;
    if (&command == &program_) {
      std::vector<std::string> reading;
      for (const OptionText& option : command.options)
        if (is_reading_option(option)) reading.push_back(option.name());
      text += fmt::format("\n*{}*, as in [`multum bake`](#options-of-many-commands): {}.\n", kSourceGroup,
                          names_text(reading));
    }
    for (const CommandText* owner : commands_)
      if (others.contains(owner)) text += "\n" + names_of_owner(*owner, others.at(owner));
    if (!shared.empty()) text += "\n" + names_of_shared(shared);
    return text;
  }

  // Returns "Options of multum bake: --lobes ...", or a list of the exceptions if they are fewer.
  std::string names_of_owner(const CommandText& owner, const std::vector<std::string>& names) const {
    std::vector<std::string> missing;
    for (const OptionText& option : owner.options)
      if (!is_own(option) && !is_help(option) && option.long_name != "--version" &&
          !shared_.contains(identity(option)) && (owner_of(option) == &owner || is_reading_option(option)) &&
          std::find(names.begin(), names.end(), option.name()) == names.end())
        missing.push_back(option.name());
    if (missing.empty()) return fmt::format("All options of {}.\n", link(owner));
    if (missing.size() < names.size())
      return fmt::format("All options of {} except {}.\n", link(owner), names_text(missing));
    return fmt::format("Options of {}: {}.\n", link(owner), names_text(names));
  }

  std::string names_of_shared(const std::map<std::string, std::vector<std::string>>& shared) const {
    std::vector<std::string> names;
    std::string whole;
    for (const auto& [group, some] : shared) {
      if (some.size() > 2 && group != "Options" && some.size() == shared_counts_.at(group))
        whole += fmt::format(" *{}*", group);
      else names.insert(names.end(), some.begin(), some.end());
    }
    return fmt::format("[Also](#options-of-many-commands){}{}{}.\n", whole, names.empty() ? "" : " ",
                       names_text(names));
  }

  const CommandText* owner_of(const OptionText& option) const {
    const auto found = owners_.find(identity(option));
    return found == owners_.end() ? nullptr : found->second;
  }

  // Lists parameters that are described in another section, but have different keys here.
  std::string other_keys(const CommandText& command, const Columns& columns) const {
    if (columns.table == nullptr) return "";
    const ParameterTable* const described = find_parameter_table("bake");
    std::map<std::string, std::vector<std::string>> by_keys;
    for (const OptionText& option : command.options) {
      const CommandText* const owner = owner_of(option);
      if (!shared_.contains(identity(option)) && (owner == nullptr || owner == &command)) continue;
      const Parameter* const here = columns.table->find(key_of(option));
      const Parameter* const there = described->find(key_of(option));
      if (here == nullptr || there == nullptr) continue;
      if (keys_text(*here) != keys_text(*there)) by_keys[keys_text(*here)].push_back(option.name());
    }
    std::string text;
    for (const auto& [keys, names] : by_keys)
      text += fmt::format("\nKeys here: {} for {}.\n", keys.empty() ? "none" : "*" + keys + "*", names_text(names));
    return text;
  }

  std::string option_tables(const CommandText& command, const Columns& columns) {
    std::vector<std::string> groups;
    std::map<std::string, std::string> rows;
    for (const OptionText& option : command.options) {
      if (is_help(option) || shared_.contains(identity(option)) || is_reading_option(option)) continue;
      if (!is_own(option) && !owners_.emplace(identity(option), &command).second) continue;
      if (rows[option.group].empty()) groups.push_back(option.group);
      rows[option.group] += option_row(option, columns);
    }
    std::string text;
    for (const std::string& group : groups)
      text += (group == "Options" || groups.size() == 1 ? "\n" : "\n**" + heading_of(group) + "**\n\n") +
              columns.head() + rows[group];
    return text;
  }

  std::string section(const CommandText& command) {
    std::string text = "\n## " + command.words + "\n\n" + help_text(command);
    const ParameterTable* const table =
        command.words == "multum " + command.name ? find_parameter_table(command.name) : nullptr;
    const Columns columns = columns_of(table);
    text += option_tables(command, columns);
    if (columns.table != nullptr) {
      std::set<std::string> shown;
      for (const OptionText& option : command.options) shown.insert(key_of(option));
      if (const std::string rows = key_rows(columns, shown); !rows.empty())
        text += "\n**Keys only**\n\n" + columns.head() + rows;
    }
    text += named_elsewhere(command) + other_keys(command, columns);
    if (is_submit(command)) text += job_types(command);
    return text;
  }

  // Returns help and examples.
  std::string help_text(const CommandText& command) const {
    std::string help = command.help.substr(0, command.help.find("\n\n"));
    std::replace(help.begin(), help.end(), '\n', ' ');
    std::string text = sentence(help) + "\n";
    std::string examples, notes;
    std::istringstream lines(command.examples);
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("  multum")) examples += line.substr(2) + "\n";
      else if (!line.starts_with("Example")) notes += line + "\n";
    }
    if (!examples.empty()) text += "\n```sh\n" + examples + "```\n";
    if (notes.find_first_not_of('\n') != std::string::npos) {
      notes.erase(0, notes.find_first_not_of('\n'));
      notes.erase(notes.find_last_not_of('\n') + 1);
      text += "\n" + cell(notes) + "\n";
    }
    return text;
  }

  // Lists the options that all job types have. The options of a single type are parameters with the key j.
  std::string job_types(const CommandText& submit) {
    std::string types, rows;
    std::set<std::string> done;
    for (const CommandText& type : submit.commands) {
      types += fmt::format("- `{}`: {}\n", type.name, sentence(type.help));
      const ParameterTable* const table = find_parameter_table(type.name);
      for (const OptionText& option : type.options) {
        if (table != nullptr && table->find(key_of(option)) != nullptr) continue;
        if (is_help(option) || shared_.contains(identity(option)) || !done.insert(option.name()).second) continue;
        rows += option_row(option, {});
      }
    }
    return "\nTypes of jobs:\n\n" + types +
           "\nEvery key of a job type that is marked *j* is also an option: `--first-level` for `first_level`. All "
           "types have these options:\n\n" +
           Columns{}.head() + rows;
  }

  static std::string scene_section() {
    const ParameterTable* const table = find_parameter_table("scene");
    Columns columns{table, false};
    return "\n## Jobs of type scene\n\nThe parameters of the maps are in the scene file.\n\n" + columns.head() +
           key_rows(columns);
  }

  const CommandText& program_;
  std::vector<const CommandText*> commands_;
  std::set<std::string> shared_;
  std::map<std::string, std::size_t> shared_counts_;  // number of shared options by group
  std::map<std::string, const CommandText*> owners_;  // the section that describes an option, by option identity
};

}  // namespace

std::string command_page_head() { return kHead; }

std::string command_page_part(const CommandText& program) { return Page(program).text(); }

}  // namespace multum
