// SPDX-License-Identifier: Apache-2.0
// The filter with which renderers should read baked files. Errors are also measured with this filter. It averages at
// most N trilinear lookups ("taps"), with a level bias, along the longer axis of a pixel's footprint.
// runtime_gl/shaders/common/texture_filter.glsl explains the formulas. docs/evidence/FILTER.md shows how the defaults
// were chosen.
#pragma once

#include <algorithm>
#include <cmath>

namespace multum {

constexpr int kTapCountMax = 16;
constexpr int kTapCountDefault = 4;
constexpr double kLevelBiasDefault = -0.5;  // in levels
constexpr bool kShadesTapsDefault = false;
constexpr double kTapOverlap = 0.75;  // in levels; makes neighbouring taps overlap

struct TapFilter {
  int taps_max = kTapCountDefault;        // 1 to kTapCountMax
  double level_bias = kLevelBiasDefault;  // in levels
  bool shades_taps = kShadesTapsDefault;  // true shades each tap, and false averages the taps first

  /// Returns the number of taps N for a footprint whose sides are given in texels of level 0.
  int tap_count(double longer, double shorter) const {
    constexpr double kRounding = 1e-3;  // the same rounding as in the shader, so that a ratio of about 2 gives two taps
    const double ratio = std::min(longer / std::max(shorter, 1e-20), static_cast<double>(taps_max));
    return std::max(static_cast<int>(std::ceil(ratio - kRounding)), 1);
  }
  /// Returns the level of detail of each tap, before it is clamped to the existing levels.
  double level(double longer, double shorter) const {
    const int count = tap_count(longer, shorter);
    const double width = count == 1 ? longer : std::max(shorter, longer / count * std::exp2(-kTapOverlap));
    return std::log2(std::max(width, 1e-15)) + level_bias;
  }
  /// Returns the place of tap i (counted from 0) of `count` taps along the longer axis, from -1/2 to 1/2.
  static double place(int i, int count) { return (i + 0.5) / count - 0.5; }
};

}  // namespace multum
