// SPDX-License-Identifier: Apache-2.0
// Chooses the signs of anisotropy axes. An axis has no sign, but textures store a direction with a sign. If two texels
// had opposite directions, the axis would be lost when they are filtered. All directions of a map and its levels are
// therefore in one half plane, whose border is at the angle with the fewest axes.
#pragma once

#include <glm/vec2.hpp>

#include "host/formats/image/plane_store.h"

namespace multum {

/// Returns the angle, 0 to pi, with the fewest axes of the map. Each axis belongs to a block of 4 x 4 normals and is
/// weighted by the block's anisotropy.
double find_axis_cut(const PlaneStore& normals);

/// Returns the axis with the sign that puts it between `cut` and `cut` + pi.
glm::vec2 signed_axis(glm::vec2 axis, double cut);

}  // namespace multum
