// SPDX-License-Identifier: Apache-2.0
// Lists the parameter tables of all commands.
#pragma once

#include <string>
#include <vector>

#include "host/foundation/parameters/parameter.h"

namespace multum {

/// Returns the tables of all commands, in the order of docs/reference/commands.md.
const std::vector<const ParameterTable*>& parameter_tables();

/// Returns the table of a command or job type, or null if there is no table.
const ParameterTable* find_parameter_table(const std::string& command);

/// Describes the legal values and the default of a parameter, as in "an integer from 1 to 8, default 4".
std::string values_text(const Parameter& parameter);

}  // namespace multum
