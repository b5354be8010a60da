// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/parameter_options.h"

#include <fmt/format.h>

#include <algorithm>

namespace multum {
namespace {

// Returns text such as "INT in [1, 8]" or "FILE[:CHANNEL]".
std::string type_text(const Parameter& row) {
  const auto range = [&](const char* type) {
    std::string text = type;
    if (row.has_low() && row.has_high())
      text += fmt::format(" in {}{:g}, {:g}]", row.low_excluded ? "(" : "[", row.low, row.high);
    else if (row.has_low()) text += fmt::format(" {} {:g}", row.low_excluded ? ">" : ">=", row.low);
    return text + (row.zero_excluded ? " other than 0" : "") + (row.unit.empty() ? "" : " " + row.unit);
  };
  switch (row.kind) {
    case ParameterKind::kInteger: return range("INT");
    case ParameterKind::kNumber: return range("FLOAT");
    case ParameterKind::kBytes: return "SIZE";
    case ParameterKind::kBrdf: return "BRDF";
    case ParameterKind::kFile: return row.unit.empty() ? "FILE" : row.unit;
    case ParameterKind::kChoice: {
      if (!row.unit.empty()) return row.unit;
      std::string text;
      for (const std::string& choice : row.choices) text += (text.empty() ? "{" : ",") + choice;
      return text + "}";
    }
    default: return row.unit.empty() ? "TEXT" : row.unit;
  }
}

void set_given(ParameterValues& values, const Parameter& row, ParameterValue value) {
  values.set(row.name, std::move(value));
  check_exclusions(values);
}

// `names` are in the form of CLI11, such as "-d,--data-format".
CLI::Option* add_option(CLI::App& app, const std::string& names, ParameterValues& values, const Parameter& row) {
  if (row.kind == ParameterKind::kFlag)
    return app.add_flag_callback(
        names, [&values, &row] { set_given(values, row, true); }, row.help);
  if (row.is_repeatable)
    return app.add_option_function<std::vector<std::string>>(
        names,
        [&values, &row](const std::vector<std::string>& texts) {
          std::string joined;
          for (const std::string& text : texts) joined += (joined.empty() ? "" : ";") + text;
          set_given(values, row, joined);
        },
        row.help + "; repeatable");
  return app.add_option_function<std::string>(
      names,
      [&values, &row](const std::string& text) {
        const std::optional<ParameterValue> value = parse_value(row, text);
        // A value that cannot be parsed remains a string, which set() then refuses.
        set_given(values, row, value ? *value : ParameterValue(text));
      },
      row.help);
}

}  // namespace

void add_parameter_options(CLI::App& app, ParameterValues& values, const std::vector<std::string>& names,
                           bool shows_defaults) {
  std::vector<const Parameter*> rows;
  for (const Parameter& row : values.table().rows())
    if (row.is_on(kOnCommandLine) && (names.empty() || std::find(names.begin(), names.end(), row.name) != names.end()))
      rows.push_back(&row);
  for (const Parameter* row : rows) {
    const std::string short_name = row->short_option.empty() ? "" : row->short_option + ",";
    CLI::Option* const option = add_option(app, short_name + row->option(), values, *row);
    if (!row->group.empty()) option->group(row->group);
    if (row->kind != ParameterKind::kFlag) option->type_name(type_text(*row));
    if (shows_defaults && !row->default_text.empty() && row->kind != ParameterKind::kFlag)
      option->default_str(row->default_text);
  }
  // This affects only the help text, because check_exclusions() refuses excluded pairs during parsing.
  for (const Parameter* row : rows)
    for (const std::string& name : row->excludes)
      if (CLI::Option* const other = app.get_option_no_throw(values.table().at(name).option()))
        app.get_option(row->option())->excludes(other);
}

std::string shown_name(const CLI::Option& option) {
  return option.get_lnames().empty() ? option.get_name() : "--" + option.get_lnames().front();
}

}  // namespace multum
