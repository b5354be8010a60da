// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/toml/parameter_keys.h"

#include <fmt/format.h>

#include <limits>

namespace multum {
namespace {

ParameterValue read_value(const StrictTable& table, const Parameter& parameter) {
  const std::string& key = parameter.name;
  switch (parameter.kind) {
    case ParameterKind::kFlag: return table.boolean(key, false);
    case ParameterKind::kInteger:
      return std::int64_t{table.whole(key, static_cast<int>(parameter.low), static_cast<int>(parameter.high))};
    case ParameterKind::kNumber:
      return table.number(key, {parameter.low, parameter.high, parameter.low_excluded, false, expected_text(parameter)},
                          0.0);
    case ParameterKind::kFile: return table.path(key, "");
    default: return table.text(key, "");
  }
}

}  // namespace

void read_parameters(const StrictTable& table, unsigned surface, ParameterValues& values) {
  for (const Parameter& row : values.table().rows()) {
    if (!row.is_on(surface) || !table.has(row.name)) continue;
    const ParameterValue value = read_value(table, row);
    if (!is_legal(row, value))
      table.refuse(row.name, fmt::format("is {}, expected {}", value_text(value), expected_text(row)));
    values.set(row.name, value);
    for (const std::string& other : row.excludes)
      if (!table.has(other)) values.erase(other);
      else if (values.is_given(row.name) && values.is_given(other))
        table.refuse(row.name, fmt::format("is given together with {}: expected only one of them", other));
  }
}

}  // namespace multum
