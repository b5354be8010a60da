// SPDX-License-Identifier: Apache-2.0
// The filter that renderers should read baked files through, and that errors are measured through: up to N trilinear
// lookups ("taps") along the longer axis of a pixel's footprint, with a level bias.
// runtime_gl/shaders/common/texture_filter.glsl has the same formulas and says why; docs/evidence/FILTER.md has what
// the defaults were chosen from.
#pragma once

#include <algorithm>
#include <cmath>

namespace multum {

constexpr int kTapCountMax = 16;
constexpr int kTapCountDefault = 4;
constexpr double kLevelBiasDefault = -0.5;  // levels
constexpr bool kShadesTapsDefault = false;
constexpr double kTapOverlap = 0.75;  // levels: neighbouring taps overlap

struct TapFilter {
  int taps_max = kTapCountDefault;        // 1 to kTapCountMax
  double level_bias = kLevelBiasDefault;  // levels
  bool shades_taps = kShadesTapsDefault;  // each tap by itself; else what they return is averaged first

  /// N of a footprint of these sides, in texels of level 0.
  int tap_count(double longer, double shorter) const {
    constexpr double kRounding = 1e-3;  // as in the shader: a ratio of 2, rounded, is two taps, not three
    const double ratio = std::min(longer / std::max(shorter, 1e-20), static_cast<double>(taps_max));
    return std::max(static_cast<int>(std::ceil(ratio - kRounding)), 1);
  }
  /// The level of detail of each tap, before it is clamped to the levels that there are.
  double level(double longer, double shorter) const {
    const int count = tap_count(longer, shorter);
    const double width = count == 1 ? longer : std::max(shorter, longer / count * std::exp2(-kTapOverlap));
    return std::log2(std::max(width, 1e-15)) + level_bias;
  }
  /// Where tap i, from 0, of `count` lies along the longer axis: -1/2 to 1/2.
  static double place(int i, int count) { return (i + 0.5) / count - 0.5; }
};

}  // namespace multum
