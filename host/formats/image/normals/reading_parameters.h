// SPDX-License-Identifier: Apache-2.0
// Applies the parameters that say how a map is read (kSourceGroup of bake_parameters()).
#pragma once

#include <optional>

#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/surface_points.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// The parameter `surface`, where it is given.
std::optional<MapSurface> map_surface(const ParameterValues& values);

/// The parameter `z_range`, where it is given.
std::optional<ZRange> z_range(const ParameterValues& values);

/// What was given replaces what `settings` hold. `values` are of bake_parameters().
void apply_reading(const ParameterValues& values, NormalMapSettings& settings);

}  // namespace multum
