// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/parameter_tables.h"

#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/check_parameters.h"
#include "host/foundation/parameters/export_parameters.h"
#include "host/foundation/parameters/gltf_parameters.h"
#include "host/foundation/parameters/infer_parameters.h"
#include "host/foundation/parameters/pack_parameters.h"
#include "host/foundation/parameters/pyramid_parameters.h"

namespace multum {
const std::vector<const ParameterTable*>& parameter_tables() {
  static const std::vector<const ParameterTable*> tables = {
      &bake_parameters(), &scene_parameters(), &infer_parameters(), &pack_parameters(),        &export_parameters(),
      &gltf_parameters(), &check_parameters(), &mip_parameters(),   &reflectance_parameters(), &lod_parameters()};
  return tables;
}

const ParameterTable* find_parameter_table(const std::string& command) {
  for (const ParameterTable* table : parameter_tables())
    if (table->command() == command) return table;
  return nullptr;
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

}  // namespace multum
