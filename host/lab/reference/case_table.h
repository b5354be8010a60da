// SPDX-License-Identifier: Apache-2.0
// The verdicts of numerical cases as an aligned table for terminals and as JSON, which the page of
// docs/contributing/STABILITY.md is made of.
#pragma once

#include <string>

#include "host/lab/reference/numerical_case.h"

namespace multum {

/// A line a case: its name, the worst error, the bound, the errors without the guard and with a bug where those
/// were tried, the verdict.
std::string case_table(const NumericalRun& run);

/// Errors that are not finite are the texts "NaN" and "inf".
std::string case_json(const NumericalRun& run);

/// Reads case_json(). Throws Error(kInput) naming `path` when `text` is something else.
NumericalRun parse_case_json(const std::string& text, const std::string& path);

}  // namespace multum
