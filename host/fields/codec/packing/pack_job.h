// SPDX-License-Identifier: Apache-2.0
// Connects packing to the parameter table and to its reports, for `multum pack` and for the library.
#pragma once

#include <string>

#include "host/fields/codec/packing/field_packing.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Sets all members that have a parameter. Throws Error(kUsage) for an alpha between 0 and 1.
void apply(const ParameterValues& values, FieldPackSettings& settings);

/// Returns FOLDER for "FOLDER/inferred.json", which is the form in jobs of the service. Returns other names unchanged.
std::string field_folder(const std::string& named);

/// Logs a warning for each property of the packed field that the user may not expect.
void warn_of_pack_errors(const FieldPackSettings& settings, const FieldPackReport& report);

/// Returns the JSON text of `multum pack --json`.
std::string pack_report_json(const FieldPackSettings& settings, const FieldPackReport& report);

}  // namespace multum
