// SPDX-License-Identifier: Apache-2.0
// Places the samples of a reference picture within their pixel, and measures how noisy their mean is.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <glm/vec2.hpp>

#include "runtime_gl/gl/framebuffer.h"

namespace multum::gl {

/// The weights of a pixel's surroundings. The box is the pixel's own area, 1 pixel wide. The tent is 2 pixels wide. The
/// Gaussian has a standard deviation of 1/2 pixel and is cut off at 1.5 pixels.
enum class PixelFilter { kBox, kTent, kGaussian };

constexpr double kReferenceNoise = 0.005;        // relative L1 difference
constexpr int kReferenceSampleCountMax = 65536;  // limit of the sample count if the noise stays above its target
constexpr int kReferenceBatch = 64;              // samples between measurements of the noise

struct ReferenceSampling {
  int sample_count = 0;                // per pixel, 1 to kReferenceSampleCountMax; with 0, samples until `noise_max` is
                                       // reached
  double noise_max = kReferenceNoise;  // relative L1, > 0
  PixelFilter filter = PixelFilter::kBox;
};

/// Returns a sample's offset from the pixel's middle, in pixels. Maps Roberts' R2 sequence (multiples of 1/g and 1/g^2,
/// g^3 = g + 1), which is evenly spread for every count, through the inverse of the filter's distribution in each
/// direction.
glm::vec2 reference_offset(PixelFilter filter, int sample);

/// Sums batches of samples in double precision, alternating between two halves. The difference of the halves measures
/// the noise of the whole. If their errors are independent, the error of their mean is half of their difference.
class ReferenceSum {
 public:
  ReferenceSum(int width, int height);

  /// `sum` is the sum of `sample_count` pictures.
  void add(const FloatImage& sum, int sample_count);
  int sample_count() const { return counts_[0] + counts_[1]; }
  /// Returns the relative L1 difference of the RGB values of all pixels. This is the sum of |a - b| / 2 divided by the
  /// sum of (a + b) / 2, where a and b are the means of the halves. Returns infinity before the second batch, and 0 if
  /// everything is black.
  double noise() const;
  FloatImage mean() const;

 private:
  int width_, height_;
  std::array<std::vector<double>, 2> halves_;
  std::array<int, 2> counts_{};
  int next_ = 0;
};

}  // namespace multum::gl
