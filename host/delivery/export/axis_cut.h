// SPDX-License-Identifier: Apache-2.0
// Chooses signs of axes. An axis of anisotropy has no sign, but textures hold a direction: filtered between two
// texels of opposite signs, the axis is lost. So all directions of a map, of all its levels, lie in one half plane,
// whose border is where the fewest axes are.
#pragma once

#include <glm/vec2.hpp>

#include "host/formats/image/plane_store.h"

namespace multum {

/// The angle, 0 to pi, at which the fewest axes of the map lie: of blocks of 4 x 4 normals, weighed by their
/// anisotropy.
double find_axis_cut(const PlaneStore& normals);

/// The axis with the sign that puts it between `cut` and `cut` + pi.
glm::vec2 signed_axis(glm::vec2 axis, double cut);

}  // namespace multum
