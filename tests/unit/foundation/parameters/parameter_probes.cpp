// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/foundation/parameters/parameter_probes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/export_parameters.h"
#include "host/foundation/parameters/gltf_parameters.h"
#include "host/foundation/parameters/infer_parameters.h"
#include "host/foundation/parameters/pack_parameters.h"
#include "host/foundation/parameters/pyramid_parameters.h"

namespace multum::testing {
namespace {

using Json = nlohmann::json;

Probe number_probe(const Parameter& row, double value, bool is_legal) {
  const std::string text =
      row.kind == ParameterKind::kNumber ? fmt::format("{:.17g}", value) : fmt::format("{:.0f}", value);
  const bool is_fraction = value != std::floor(value);
  Json json = row.kind == ParameterKind::kNumber || is_fraction ? Json(value) : Json(static_cast<std::int64_t>(value));
  return {text, json, text, is_legal};
}

Probe text_probe(const std::string& text, bool is_legal) { return {text, text, "\"" + text + "\"", is_legal}; }

// Tries values at, just below and just above each bound. Also tries each choice, an unknown choice, and values of
// another type.
std::vector<Probe> probes_of(const Parameter& row) {
  std::vector<Probe> probes;
  switch (row.kind) {
    case ParameterKind::kInteger:
    case ParameterKind::kBytes:
      probes = {number_probe(row, row.low, true), number_probe(row, row.high, true),
                number_probe(row, row.low - 1, false), number_probe(row, row.high + 1, false)};
      probes.push_back({"1.5", 1.5, "1.5", false});
      probes.push_back(text_probe("much", false));
      break;
    case ParameterKind::kNumber:
      if (row.has_low()) {
        probes.push_back(number_probe(row, row.low, !row.low_excluded));
        probes.push_back(number_probe(row, std::nextafter(row.low, -INFINITY) - 1e-9, false));
        probes.push_back(number_probe(row, row.low + 1e-6, true));
      } else {
        probes.push_back(number_probe(row, -2.0, true));
      }
      if (row.has_high()) {
        probes.push_back(number_probe(row, row.high, true));
        probes.push_back(number_probe(row, row.high * (1.0 + 1e-9), false));
      } else {
        probes.push_back(number_probe(row, 1e9, true));
      }
      if (row.zero_excluded) probes.push_back(number_probe(row, 0.0, false));
      probes.push_back(text_probe("much", false));
      break;
    case ParameterKind::kChoice:
      for (const std::string& choice : row.choices) probes.push_back(text_probe(choice, true));
      probes.push_back(text_probe("none such", false));
      break;
    default: break;  // texts and flags have no bounds
  }
  return probes;
}

}  // namespace

std::vector<const ParameterTable*> all_tables() {
  return {&bake_parameters(), &scene_parameters(), &infer_parameters(),       &pack_parameters(), &export_parameters(),
          &gltf_parameters(), &mip_parameters(),   &reflectance_parameters(), &lod_parameters()};
}

void for_each_probe(const ParameterTable& table, unsigned surface,
                    const std::function<void(const Parameter&, const Probe&)>& call) {
  for (const Parameter& row : table.rows())
    if (row.is_on(surface))
      for (const Probe& probe : probes_of(row)) {
        SCOPED_TRACE(table.command() + " " + row.name + " = " + probe.command_line);
        call(row, probe);
      }
}

std::optional<ParameterValue> another_value(const Parameter& row) {
  if (row.kind == ParameterKind::kFlag) return true;
  if (row.kind == ParameterKind::kInteger) return static_cast<std::int64_t>(row.low) + 2;
  if (row.kind == ParameterKind::kNumber)
    return row.has_low() ? 0.5 * (row.low + std::min(row.high, row.low + 1)) : 3.0;
  if (row.kind != ParameterKind::kChoice) return std::nullopt;
  for (const std::string& choice : row.choices)
    if (choice != row.default_text) return choice;
  return std::nullopt;
}

}  // namespace multum::testing
