// SPDX-License-Identifier: Apache-2.0
// Measured errors as text: a table for people, and the attribute multum:measuredError of the baked file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bake/accuracy.h"

namespace multum {

/// A line a level and a column a BRDF; a table for each way of shading, and when there are coloured rows, tables with
/// those. Empty without rows.
std::string accuracy_table(const std::vector<AccuracyRow>& rows);

/// JSON array of [level, point, BRDF, error to six digits behind the point].
std::string measured_error_json(const std::vector<AccuracyRow>& rows);

/// What measured_error_json() wrote, without confidences and sample counts; nullopt for any other text.
std::optional<std::vector<AccuracyRow>> parse_measured_error(const std::string& json);

}  // namespace multum
