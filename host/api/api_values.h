// SPDX-License-Identifier: Apache-2.0
// The handle of settings in multum.h: values of a command's parameter table.
#pragma once

#include <optional>

#include "host/api/multum.h"
#include "host/foundation/parameters/parameter_values.h"

struct multum_values {
  multum::ParameterValues values;
  std::optional<int> threads;  // setting of every command, which no table has
};

namespace multum {

/// Returns the values, or no values for null. Throws Error(kUsage) if they are for another command, or if they choose a
/// device, which the caller has already opened.
ParameterValues values_of(const multum_values* values, const ParameterTable& table);

/// Returns the number of threads to work with: the setting, or one per core.
int threads_of(const multum_values* values);

}  // namespace multum
