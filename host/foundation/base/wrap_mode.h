// SPDX-License-Identifier: Apache-2.0
// Wrap modes define the values beyond the border of an image. They have the same names as in maketx.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

namespace multum {

enum class WrapMode { kBlack, kClamp, kPeriodic, kMirror };
inline constexpr WrapMode kWrapModes[] = {WrapMode::kBlack, WrapMode::kClamp, WrapMode::kPeriodic, WrapMode::kMirror};

inline const char* wrap_mode_name(WrapMode mode) {
  switch (mode) {
    case WrapMode::kBlack: return "black";
    case WrapMode::kClamp: return "clamp";
    case WrapMode::kPeriodic: return "periodic";
    case WrapMode::kMirror: return "mirror";
  }
  return "?";
}

inline std::optional<WrapMode> parse_wrap_mode(std::string_view name) {
  for (const WrapMode mode : kWrapModes)
    if (name == wrap_mode_name(mode)) return mode;
  return std::nullopt;
}

/// Returns the texel of a row or column of `size` texels that is visible at place `i`, which may be any integer. A
/// black border counts as a clamped one, because graphics hardware that has only repeated and clamped borders shows it
/// so.
inline int wrapped_texel(int i, int size, WrapMode mode) {
  if (mode == WrapMode::kClamp || mode == WrapMode::kBlack) return std::clamp(i, 0, size - 1);
  const int period = mode == WrapMode::kPeriodic ? size : 2 * size;
  i %= period;
  if (i < 0) i += period;
  return i < size ? i : period - 1 - i;
}

/// The texels of a row or column at places `i` and `i` + 1.
struct TexelPair {
  int first, second;

  static TexelPair at(int i, int size, WrapMode mode) {
    const int first = wrapped_texel(i, size, mode);
    // One division is enough for the most frequent mode.
    if (mode == WrapMode::kPeriodic) return {first, first + 1 < size ? first + 1 : 0};
    return {first, wrapped_texel(i + 1, size, mode)};
  }
};

}  // namespace multum
