// SPDX-License-Identifier: Apache-2.0
// Reads parameters from a table of a TOML file.
#pragma once

#include "host/foundation/parameters/parameter_values.h"
#include "host/foundation/toml/strict_toml.h"

namespace multum {

/// Reads the keys that are parameters of values.table() and are allowed at `surface`. Sets these parameters in
/// `values`. If a key excludes a parameter, the value of that parameter is removed. Throws Error(kInput) for a value
/// that is not legal, with file and line: "maps.toml:7: map.lobes is 9, expected an integer from 1 to 8".
void read_parameters(const StrictTable& table, unsigned surface, ParameterValues& values);

}  // namespace multum
