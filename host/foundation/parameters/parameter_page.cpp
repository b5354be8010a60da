// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/parameter_page.h"

#include <fmt/format.h>

#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/export_parameters.h"
#include "host/foundation/parameters/gltf_parameters.h"
#include "host/foundation/parameters/infer_parameters.h"
#include "host/foundation/parameters/pack_parameters.h"
#include "host/foundation/parameters/pyramid_parameters.h"

namespace multum {
namespace {

constexpr char kHead[] =
    "# Parameters\n\n"
    "All parameters of the commands below, of manifests ([CI](CI.md)), scenes ([SCENE](SCENE.md)) and jobs of the "
    "service ([SERVICE](SERVICE.md)).\n"
    "This page is written by `tools/parameter_documents` from `host/foundation/parameters`, where each is one row.\n\n"
    "On a command line `first_level` is `--first-level`. *Where*: c, the command line; m, a manifest's `[defaults]` "
    "and `[[map]]`; s, a scene's\n`[[map]]`; j, a job's `parameters`. *Hashed as*: the key of `multum:settings` "
    "([FORMAT](FORMAT.md)) that holds it; parameters\nwithout one change no content.\n";

// What ends a cell of a Markdown table.
std::string escaped(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) text.insert(at, "\\");
  return text;
}

std::string where_text(const Parameter& row) {
  std::string text;
  for (const auto& [surface, letter] : {std::pair{kOnCommandLine, "c"}, std::pair{kInManifest, "m"},
                                        std::pair{kInScene, "s"}, std::pair{kInService, "j"}})
    if (row.is_on(surface)) text += (text.empty() ? "" : " ") + std::string(letter);
  return text;
}

std::string scope_note(const Parameter& row) {
  switch (row.scope) {
    case ParameterScope::kAll: return "";
    case ParameterScope::kLobes: return "; for lobes (vmf, gmm)";
    case ParameterScope::kHarmonics: return "; for sh";
  }
  return "";
}

std::string row_text(const Parameter& row) {
  std::string note = scope_note(row) + (row.chosen_by_target ? "; chosen by a target" : "");
  for (const std::string& other : row.excludes)
    note += (other == row.excludes.front() ? "; excludes `" : ", `") + other + "`";
  return fmt::format("| `{}` | {} | {} | {} | {}{} |\n", row.name, escaped(values_text(row)), where_text(row),
                     row.hashed_as.empty() ? "" : "`" + row.hashed_as + "`", escaped(row.help), note);
}

}  // namespace

const std::vector<const ParameterTable*>& parameter_tables() {
  static const std::vector<const ParameterTable*> tables = {
      &bake_parameters(), &scene_parameters(), &infer_parameters(),       &pack_parameters(), &export_parameters(),
      &gltf_parameters(), &mip_parameters(),   &reflectance_parameters(), &lod_parameters()};
  return tables;
}

std::string values_text(const Parameter& row) {
  std::string text = row.kind == ParameterKind::kFlag ? "flag" : expected_text(row);
  const bool has_form = row.kind == ParameterKind::kText || row.kind == ParameterKind::kFile ||
                        (row.kind == ParameterKind::kChoice && !row.unit.empty());
  if (has_form && !row.unit.empty()) text = row.unit;
  else if (row.is_numeric() && !row.unit.empty() && row.kind != ParameterKind::kBytes) text += ", " + row.unit;
  if (!row.default_text.empty() && row.kind != ParameterKind::kFlag) text += ", default " + row.default_text;
  return text;
}

std::string parameter_page() {
  std::string page = kHead;
  for (const ParameterTable* table : parameter_tables()) {
    const bool is_job = table == &scene_parameters();
    page += is_job ? "\n## Jobs of type scene\n" : fmt::format("\n## `multum {}`\n", table->command());
    std::string group = "none";
    for (const Parameter& row : table->rows()) {
      const std::string heading = row.surfaces == 0 ? "Fixed by the program, and hashed" : row.group;
      if (heading != group) {
        if (!heading.empty() && heading != "Options") page += fmt::format("\n**{}**\n", heading);
        page += "\n| parameter | values | where | hashed as | meaning |\n|---|---|---|---|---|\n";
        group = heading;
      }
      page += row_text(row);
    }
  }
  return page;
}

}  // namespace multum
