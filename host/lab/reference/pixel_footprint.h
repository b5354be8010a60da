// SPDX-License-Identifier: Apache-2.0
// Computes the reference and the model of a pixel directly from their definitions, in double precision. The reference
// averages the values at dense points in the pixel's rectangle. The model filters the values with trilinear taps,
// according to the equations of OpenGL. This code is slow. Tests compare host/bakes/accuracy with it.
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

/// Returns the mean of the texel values at side_points x side_points points. Points beyond a clamped border are
/// omitted, because the surface ends there. At points beyond a black border, the value is 0.
double rectangle_average(const ValuePlane& finest, const PixelRectangle& pixel, BorderModes borders, int side_points);

/// Filters with N trilinear taps along the longer side. The rectangle is in texels of level 0. N = ceil(longer /
/// shorter), at most taps_max. lambda is bias + log2(longer) for one tap, and bias + max(log2(shorter), log2(longer /
/// N) - 3/4) for several taps.
double filtered_value(const std::vector<ValuePlane>& levels, const PixelRectangle& pixel, BorderModes borders,
                      int taps_max, double level_bias);

}  // namespace multum::reference
