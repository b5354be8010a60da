// SPDX-License-Identifier: Apache-2.0
// Averages values over a pixel's rectangle by dense points, and filters them by trilinear taps as the GL's equations
// have it: what a pixel should show and what it does, in double and by definition. Slow; host/accuracy is held to it.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec2.hpp>

#include "host/base/wrap_mode.h"

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

/// N trilinear taps along the longer side (GL_EXT_texture_filter_anisotropic's example), of a pyramid whose level 0 has
/// the size that the rectangle is measured in: lambda = log2(longer / N) + bias, N = ceil(longer / shorter), at most
/// taps_max.
double filtered_value(const std::vector<ValuePlane>& levels, const PixelRectangle& pixel, BorderModes borders,
                      int taps_max, double level_bias);

}  // namespace multum::reference
