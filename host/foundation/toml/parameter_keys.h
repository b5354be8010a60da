// SPDX-License-Identifier: Apache-2.0
// Reads parameters from a table of a TOML file.
#pragma once

#include <optional>
#include <string>

#include "host/foundation/parameters/parameter_values.h"
#include "host/foundation/toml/strict_toml.h"

namespace multum {

/// The name under which the table has the parameter, a former one perhaps; unset: it has none of them. Throws
/// Error(kInput) where it has two.
std::optional<std::string> key_of(const StrictTable& table, const Parameter& parameter);

/// Reads the keys that are parameters of values.table() on `surface` and puts them on top of what `values` hold: one
/// that excludes another takes that one's value away. Throws Error(kInput) for a value that is not legal, with file and
/// line: "maps.toml:7: map.lobes is 9, expected an integer from 1 to 8".
void read_parameters(const StrictTable& table, unsigned surface, ParameterValues& values);

}  // namespace multum
