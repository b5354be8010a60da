// SPDX-License-Identifier: Apache-2.0
// The filter that errors are measured through: the runtime's own, N trilinear taps spread evenly along the longer axis
// of the pixel's footprint, as the example of GL_EXT_texture_filter_anisotropic has it, with a level bias. What the
// runtime draws with by default stands here for the measurement: change both together.
#pragma once

#include <algorithm>
#include <cmath>

namespace multum {

constexpr int kFilterTapsMax = 4;          // N at most
constexpr double kFilterLevelBias = -0.5;  // added to the level of detail

struct PixelFilter {
  int taps_max = kFilterTapsMax;         // 1 to 16
  double level_bias = kFilterLevelBias;  // levels

  /// N of a footprint of these sides, in texels of level 0.
  int tap_count(double longer, double shorter) const {
    constexpr double kRounding = 1e-9;  // 2 / 1 is two taps, not three
    return std::clamp(static_cast<int>(std::ceil(longer / shorter - kRounding)), 1, taps_max);
  }
  /// lambda = log2(longer / N) + bias, before it is clamped to the levels that there are.
  double level(double longer, double shorter) const {
    return std::log2(longer / tap_count(longer, shorter)) + level_bias;
  }
  /// Where tap i, from 0, of `count` lies along the longer axis: -1/2 to 1/2.
  static double place(int i, int count) { return (i + 1.0) / (count + 1.0) - 0.5; }
};

}  // namespace multum
