// SPDX-License-Identifier: Apache-2.0
// Measures the error of a picture against the reference.
#pragma once

#include "runtime_gl/gl/framebuffer.h"

namespace multum::gl {

/// The error over the linear RGB of all pixels.
struct PictureError {
  double relative_l1 = 0.0;  // sum |picture - reference| / sum reference; 0.05 = 5 %
  double rmse = 0.0;         // square root of the mean squared difference
};

PictureError picture_error(const FloatImage& picture, const FloatImage& reference);

/// Returns |picture - reference| times `gain`, with alpha 1.
FloatImage difference_image(const FloatImage& picture, const FloatImage& reference, float gain = 1.0f);
constexpr float kDifferenceGain = 4.0f;  // gain of displayed difference images

}  // namespace multum::gl
