// SPDX-License-Identifier: Apache-2.0
// Finds the step between the values of a height field, and whether its slopes are terraces of such steps.
#pragma once

#include <string>

#include "host/formats/image/normals/height_surface.h"

namespace multum {

struct HeightSteps {
  double step = 0.0;        // all examined values are multiples of this step, plus an offset; 0 if there is no step
  double edge_share = 0.0;  // share of terrace edges among triples of neighbouring texels that are not all equal
  /// Returns the tilt, in degrees, of a texel whose two neighbours differ by one step. A smooth slope cannot have a
  /// smaller tilt, except for 0.
  double degrees(double height_scale) const;
  /// Returns whether most triples that are not flat are terrace edges, with a visible step.
  bool are_terraces(double height_scale) const;
};

/// Examines at most 512 rows, evenly spaced, each with the two rows below it.
HeightSteps measure_steps(const HeightSurface& surface);

/// Returns "1/255 (8 bits)" or "0.1 in the file's own numbers".
std::string step_text(const HeightSteps& steps, const HeightSurface& surface);

}  // namespace multum
