// SPDX-License-Identifier: Apache-2.0
// Makes the options of a command from its parameter table.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Adds an option for each parameter of values.table() that is on command lines, or only for those in `names`, under
/// the headings of their groups. Given values go into `values`, which must outlive the app. --help shows types, ranges
/// and defaults; with `shows_defaults` false no defaults, because unset has another meaning. Parsing throws
/// Error(kUsage) for an illegal value: "--lobes is 9, expected an integer from 1 to 8".
void add_parameter_options(CLI::App& app, ParameterValues& values, const std::vector<std::string>& names = {},
                           bool shows_defaults = true);

/// "--lobes", also for hidden options, for which CLI11 returns no name; "input" for a positional.
std::string shown_name(const CLI::Option& option);

}  // namespace multum
