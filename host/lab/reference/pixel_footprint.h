// SPDX-License-Identifier: Apache-2.0
// Averages values over a pixel's rectangle by dense points, and filters them by trilinear taps as the GL's equations
// have it: what a pixel should show and what it does, in double and by definition. Slow; host/bakes/accuracy is held to
// it.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec2.hpp>

#include "host/foundation/base/wrap_mode.h"

namespace multum::reference {

/// A plane of values, row by row.
struct ValuePlane {
  int width, height;
  std::vector<double> values;
};

/// A rectangle in texels.
struct PixelRectangle {
  glm::dvec2 centre, longer_side, shorter_side;
};

struct BorderModes {
  WrapMode s = WrapMode::kPeriodic, t = WrapMode::kPeriodic;
};

/// The mean over side_points x side_points points of the value of the texel that each lies in. Beyond a clamped border
/// there is no surface, and no point; beyond a black one it is 0.
double rectangle_average(const ValuePlane& finest, const PixelRectangle& pixel, BorderModes borders, int side_points);

/// N trilinear taps along the longer side, of a pyramid whose level 0 has the size that the rectangle is measured in:
/// N = ceil(longer / shorter), at most taps_max; lambda = bias + log2(longer) of one tap, bias + max(log2(shorter),
/// log2(longer / N) - 3/4) of several.
double filtered_value(const std::vector<ValuePlane>& levels, const PixelRectangle& pixel, BorderModes borders,
                      int taps_max, double level_bias);

}  // namespace multum::reference
