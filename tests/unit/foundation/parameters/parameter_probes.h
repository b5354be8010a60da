// SPDX-License-Identifier: Apache-2.0
// Lists values at, below and above the bounds of every parameter, and former names of parameters.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/parameters/parameter.h"

namespace multum::testing {

std::vector<const ParameterTable*> all_tables();

/// Holds a value as each surface writes it, and whether the value must be accepted.
struct Probe {
  std::string command_line;
  nlohmann::json json;
  std::string toml;
  bool is_legal;
};

/// Visits each row on `surface` with values at, just below and just above each bound, with each choice and an unknown
/// choice, and with values of another type.
void for_each_probe(const ParameterTable& table, unsigned surface,
                    const std::function<void(const Parameter&, const Probe&)>& call);

/// Returns a legal value other than the default; nullopt for texts and files.
std::optional<ParameterValue> another_value(const Parameter& row);

}  // namespace multum::testing
