// SPDX-License-Identifier: Apache-2.0
// Applies the parameters for reading a map (kSourceGroup of bake_parameters()).
#pragma once

#include <optional>

#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/surface_points.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Returns the parameter `surface`, if given.
std::optional<MapSurface> map_surface(const ParameterValues& values);

/// Returns the parameter `z_range`, if given.
std::optional<ZRange> z_range(const ParameterValues& values);

/// Overwrites `settings` with the parameters that are given. `values` must belong to bake_parameters().
void apply_reading(const ParameterValues& values, NormalMapSettings& settings);

}  // namespace multum
