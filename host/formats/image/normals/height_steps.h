// SPDX-License-Identifier: Apache-2.0
// The steps that a height field's values come in, and whether its slopes are terraces of them.
#pragma once

#include <string>

#include "host/formats/image/normals/height_surface.h"

namespace multum {

struct HeightSteps {
  double step = 0.0;        // all values looked at are multiples of it, but for an offset; 0: there is none
  double edge_share = 0.0;  // of three texels in a line that are not all equal, those at the edge of a terrace
  /// Tilt in degrees of a texel between two that are one step apart: of a smooth slope, the next value after 0.
  double degrees(double height_scale) const;
  /// Most of what is not flat are edges of terraces, and a step is large enough to be seen.
  bool are_terraces(double height_scale) const;
};

/// Looks at 512 rows at most, evenly spaced, each with the two below it.
HeightSteps measure_steps(const HeightSurface& surface);

/// "1/255 (8 bits)", "0.1 of the file's own units".
std::string step_text(const HeightSteps& steps, const HeightSurface& surface);

}  // namespace multum
