// SPDX-License-Identifier: Apache-2.0
// Makes the options of a command from its table of parameters.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Adds an option for each parameter of values.table() that command lines have, or for those that `names` lists, under
/// their groups' headings; what is given goes into `values`, which must outlive the app. --help shows types, ranges and
/// defaults; `shows_defaults` false: no defaults, because unset means something else here. Parsing throws
/// Error(kUsage) for a value that is not legal: "--lobes is 9, expected an integer from 1 to 8".
void add_parameter_options(CLI::App& app, ParameterValues& values, const std::vector<std::string>& names = {},
                           bool shows_defaults = true);

/// "--lobes", of hidden options, too, which CLI11 itself gives no name; of a positional "input".
std::string shown_name(const CLI::Option& option);

}  // namespace multum
