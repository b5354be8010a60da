// SPDX-License-Identifier: Apache-2.0
// Measures the error of a picture against the truth.
#pragma once

#include "runtime_gl/gl/framebuffer.h"

namespace multum::gl {

/// Over the RGB of all pixels, linear.
struct PictureError {
  double relative_l1 = 0.0;  // sum |picture - truth| / sum truth; 0.05 = 5 %
  double rmse = 0.0;         // square root of the mean squared difference
};

PictureError picture_error(const FloatImage& picture, const FloatImage& truth);

/// |picture - truth| times `gain`, alpha 1.
FloatImage difference_image(const FloatImage& picture, const FloatImage& truth, float gain = 1.0f);
constexpr float kDifferenceGain = 4.0f;  // of differences to look at

}  // namespace multum::gl
