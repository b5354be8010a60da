// SPDX-License-Identifier: Apache-2.0
// Converts measured errors to human-readable text and to the text of the attribute multum:measuredError of baked files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"

namespace multum {

/// Formats the pixel errors, one line per BRDF: "  blinn-phong:100  9.10 +- 0.21 %; 95 % of pixels within 21.30 %;
/// ...". The text is empty if there are no errors.
std::string footprint_error_text(const std::vector<FootprintError>& errors);

/// Formats a table with a line per level and a column per BRDF, with intervals if texels were sampled. There is a table
/// for each shading method, and further tables for rows with colours. The text is empty if there are no rows.
std::string accuracy_table(const std::vector<AccuracyRow>& rows);

/// Writes a JSON array of [level, point, BRDF, error, half width of its 95 % interval], with six decimal places. Half
/// widths are rounded up, so that 0 means "all texels". If the interval of a row is not known, the row omits it. The
/// pixel errors come first: [-1, "pixels", BRDF, error, half width, 95th percentile, worst octave, its error,
/// footprints].
std::string measured_error_json(const std::vector<AccuracyRow>& rows, const std::vector<FootprintError>& errors = {});

struct StatedErrors {
  std::vector<FootprintError> footprint_errors;  // empty if the program that wrote the file measured none
  std::vector<AccuracyRow> rows;
};
/// Parses the output of measured_error_json(), also of earlier program versions, which wrote no intervals. The
/// resulting rows have no sample counts. Returns nullopt for any other text.
std::optional<StatedErrors> parse_measured_error(const std::string& json);

}  // namespace multum
