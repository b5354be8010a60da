// SPDX-License-Identifier: Apache-2.0
// Averages means, each weighted by its number of pixels.
#pragma once

namespace multum {

class PixelMean {
 public:
  void add(double mean, double pixels) {
    sum_ += mean * pixels;
    pixels_ += pixels;
  }
  double pixels() const { return pixels_; }
  /// Returns `if_none` if there are no pixels.
  double mean(double if_none) const { return pixels_ > 0.0 ? sum_ / pixels_ : if_none; }

 private:
  double sum_ = 0.0, pixels_ = 0.0;
};

}  // namespace multum
