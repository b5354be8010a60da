// SPDX-License-Identifier: Apache-2.0
// Measured errors as text: a table for people, and the attribute multum:measuredError of the baked file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/accuracy/accuracy.h"

namespace multum {

/// A line per level and a column per BRDF, with intervals where texels were sampled; a table for each way of shading,
/// and when there are coloured rows, tables with those. Empty without rows.
std::string accuracy_table(const std::vector<AccuracyRow>& rows);

/// JSON array of [level, point, BRDF, error, half width of its 95 % interval], numbers to six digits behind the point.
/// Half widths are rounded up, so that 0 says "all texels"; rows whose interval is unstated have none.
std::string measured_error_json(const std::vector<AccuracyRow>& rows);

/// What measured_error_json() wrote, without sample counts, or programs before it, without intervals; nullopt for any
/// other text.
std::optional<std::vector<AccuracyRow>> parse_measured_error(const std::string& json);

}  // namespace multum
