// SPDX-License-Identifier: Apache-2.0
// Formats the verdicts of numerical cases as an aligned table for terminals and as JSON, from which
// docs/contributing/STABILITY.md is generated.
#pragma once

#include <string>

#include "host/lab/reference/numerical_case.h"

namespace multum {

/// Writes one line per case with its name, worst error, bound and verdict. If errors without the guard and with a bug
/// were measured, the line also contains these errors.
std::string case_table(const NumericalRun& run);

/// Writes the cases as JSON. Errors that are not finite become the texts "NaN" and "inf".
std::string case_json(const NumericalRun& run);

/// Parses the output of case_json(). For any other text, throws an Error(kInput) that names `path`.
NumericalRun parse_case_json(const std::string& text, const std::string& path);

}  // namespace multum
