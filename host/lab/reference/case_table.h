// SPDX-License-Identifier: Apache-2.0
// Formats the verdicts of numerical cases as an aligned table for terminals and as JSON, from which
// docs/contributing/STABILITY.md is generated.
#pragma once

#include <string>

#include "host/lab/reference/numerical_case.h"

namespace multum {

/// Formats one line per case: name, worst error, bound, errors without the guard and with a bug if these were tested,
/// and verdict.
std::string case_table(const NumericalRun& run);

/// Errors that are not finite are written as the texts "NaN" and "inf".
std::string case_json(const NumericalRun& run);

/// Parses the output of case_json(). Throws Error(kInput) that names `path` for any other text.
NumericalRun parse_case_json(const std::string& text, const std::string& path);

}  // namespace multum
