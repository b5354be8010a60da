// SPDX-License-Identifier: Apache-2.0
// Writes the reference page of all parameters, docs/reference/parameters.md.
#pragma once

#include <string>
#include <vector>

#include "host/foundation/parameters/parameter.h"

namespace multum {

/// The tables of all commands, in the order of the page.
const std::vector<const ParameterTable*>& parameter_tables();

/// Legal values and default of one parameter: "an integer from 1 to 8, default 4".
std::string values_text(const Parameter& parameter);

/// The page in Markdown: a section a table, a row a parameter.
std::string parameter_page();

}  // namespace multum
