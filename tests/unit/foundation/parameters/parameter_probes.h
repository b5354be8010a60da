// SPDX-License-Identifier: Apache-2.0
// Values at, below and above the bounds of every parameter, and the names that parameters had.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/parameters/parameter.h"

namespace multum::testing {

std::vector<const ParameterTable*> all_tables();

/// A value as each surface writes it, and whether it is to be taken.
struct Probe {
  std::string command_line;
  nlohmann::json json;
  std::string toml;
  bool is_legal;
};

/// Each row that is on `surface`, with values at, just below and just above each bound; each choice and none of them;
/// what is of another type.
void for_each_probe(const ParameterTable& table, unsigned surface,
                    const std::function<void(const Parameter&, const Probe&)>& call);

/// A value that is legal, and not the default. Empty: texts and files.
std::optional<ParameterValue> another_value(const Parameter& row);

}  // namespace multum::testing
