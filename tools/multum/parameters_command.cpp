// SPDX-License-Identifier: Apache-2.0
// Implements multum parameters, which prints the tables of parameters as text or JSON.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/foundation/base/shown_text.h"
#include "host/foundation/parameters/parameter_tables.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

using Json = nlohmann::json;

struct ParametersOptions {
  std::string command;
  bool json = false;
};

const char* kind_name(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::kFlag: return "flag";
    case ParameterKind::kInteger: return "integer";
    case ParameterKind::kNumber: return "number";
    case ParameterKind::kChoice: return "choice";
    case ParameterKind::kText: return "text";
    case ParameterKind::kBrdf: return "brdf";
    case ParameterKind::kFile: return "file";
    case ParameterKind::kBytes: return "bytes";
  }
  return "";
}

Json row_json(const Parameter& row) {
  Json json = {{"name", row.name}, {"kind", kind_name(row.kind)}, {"help", row.help}, {"where", Json::array()}};
  for (const auto& [surface, name] : {std::pair{kOnCommandLine, "command line"}, std::pair{kInManifest, "manifest"},
                                      std::pair{kInScene, "scene"}, std::pair{kInService, "service"}})
    if (row.is_on(surface)) json["where"].push_back(name);
  if (row.is_numeric() && row.has_low()) json[row.low_excluded ? "above" : "from"] = row.low;
  if (row.is_numeric() && row.has_high()) json["to"] = row.high;
  for (const auto& [key, text] : {std::pair{"unit", &row.unit}, std::pair{"default", &row.default_text},
                                  std::pair{"group", &row.group}, std::pair{"hashed_as", &row.hashed_as}})
    if (!text->empty()) json[key] = *text;
  if (!row.choices.empty()) json["choices"] = row.choices;
  return json;
}

// Returns all tables, and the job schemas that are made from them (docs/reference/openapi.json).
nlohmann::ordered_json all_json() {
  nlohmann::ordered_json json = {{"commands", nlohmann::ordered_json::object()}, {"schemas", job_schemas()}};
  for (const ParameterTable* table : parameter_tables())
    for (const Parameter& row : table->rows())
      json["commands"][table->command()].push_back(nlohmann::ordered_json(row_json(row)));
  return json;
}

std::string tables_text(const std::string& command) {
  std::string text;
  for (const ParameterTable* table : parameter_tables()) {
    if (!command.empty() && table->command() != command) continue;
    text += (text.empty() ? "" : "\n") + table->command() + "\n";
    for (const Parameter& row : table->rows())
      if (row.surfaces != 0)
        text += fmt::format("  {:<18} {}\n  {:<18} {}\n", row.name, values_text(row), "", row.help);
  }
  return text;
}

int run_parameters(const ParametersOptions& o) {
  if (o.json) print_json(all_json());
  else write_shown(stdout, tables_text(o.command));
  return 0;
}

}  // namespace

void add_parameters_command(CLI::App& app, int* exit_code) {
  auto o = std::make_shared<ParametersOptions>();
  CLI::App* command = app.add_subcommand(
      "parameters", "list the parameters of commands, manifests and jobs with values, defaults and meaning");
  std::vector<std::string> names;
  for (const ParameterTable* table : parameter_tables()) names.push_back(table->command());
  command->add_option("command", o->command, "list only the parameters of this command")->check(CLI::IsMember(names));
  add_json_option(*command, o->json);
  command->callback([o, exit_code] { *exit_code = run_parameters(*o); });
}

}  // namespace multum
