// SPDX-License-Identifier: Apache-2.0
// The handle of settings in multum.h. It holds values for the parameter table of a command.
#pragma once

#include <optional>

#include "host/api/multum.h"
#include "host/foundation/parameters/parameter_values.h"

struct multum_values {
  multum::ParameterValues values;
  std::optional<int> threads;  // a setting of every command that is not in any table
};

namespace multum {

/// Returns the values, or no values if the handle is null. Throws Error(kUsage) if the values are for another command,
/// or if they choose a device. The caller has already opened the device.
ParameterValues values_of(const multum_values* values, const ParameterTable& table);

/// Returns the number of threads to use. This is the value of the setting, or one per core.
int threads_of(const multum_values* values);

}  // namespace multum
