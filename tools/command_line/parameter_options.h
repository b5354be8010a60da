// SPDX-License-Identifier: Apache-2.0
// Makes the options of a command from its parameter table.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Adds an option for each command-line parameter of values.table(), or only for the parameters in `names`, under the
/// headings of their groups. Stores given values in `values`, which must outlive the app. --help shows types, ranges
/// and defaults. If `shows_defaults` is false, --help shows no defaults, because an unset value then has another
/// meaning. For an illegal value, parsing throws Error(kUsage), such as "--lobes is 9, expected an integer from 1 to
/// 8".
void add_parameter_options(CLI::App& app, ParameterValues& values, const std::vector<std::string>& names = {},
                           bool shows_defaults = true);

/// Returns a name such as "--lobes", or "input" for a positional. Includes hidden options, whose names CLI11 does not
/// return.
std::string shown_name(const CLI::Option& option);

}  // namespace multum
