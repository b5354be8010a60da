// SPDX-License-Identifier: Apache-2.0
// Measured errors as text: for people, and the attribute multum:measuredError of the baked file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"

namespace multum {

/// Errors of pixels, a line a BRDF: "  blinn-phong:100  9.10 +- 0.21 %; 95 % of pixels within 21.30 %; ...". Empty
/// without errors.
std::string footprint_error_text(const std::vector<FootprintError>& errors);

/// A line per level and a column per BRDF, with intervals where texels were sampled; a table for each way of shading,
/// and when there are coloured rows, tables with those. Empty without rows.
std::string accuracy_table(const std::vector<AccuracyRow>& rows);

/// JSON array of [level, point, BRDF, error, half width of its 95 % interval], numbers to six digits behind the point.
/// Half widths are rounded up, so that 0 says "all texels"; rows whose interval is unstated have none. Before them come
/// those of pixels, [-1, "pixels", BRDF, error, half width, 95th percentile, worst octave, its error, footprints].
std::string measured_error_json(const std::vector<AccuracyRow>& rows, const std::vector<FootprintError>& errors = {});

struct StatedErrors {
  std::vector<FootprintError> footprint_errors;  // none in files of programs that did not measure them
  std::vector<AccuracyRow> rows;
};
/// What measured_error_json() wrote, rows without sample counts, or programs before it, without intervals; nullopt for
/// any other text.
std::optional<StatedErrors> parse_measured_error(const std::string& json);

}  // namespace multum
