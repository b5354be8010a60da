// SPDX-License-Identifier: Apache-2.0
// Applies the parameters that say how a map is read (kSourceGroup of bake_parameters()).
#pragma once

#include "host/image/normals/normal_map.h"
#include "host/parameters/parameter_values.h"

namespace multum {

/// What was given replaces what `settings` hold. `values` are of bake_parameters().
void apply_reading(const ParameterValues& values, NormalMapSettings& settings);

}  // namespace multum
