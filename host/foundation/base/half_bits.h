// SPDX-License-Identifier: Apache-2.0
// Converts float to IEEE half, rounded to nearest with ties to even. The conversion is done here because drivers
// differ. For example, llvmpipe (measured with Mesa 22.3.6) truncates floats that are uploaded to an RGBA16F texture,
// so the stored values are too small by half a step on average.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace multum {

/// Values beyond the range of half become infinity. NaN stays NaN.
inline std::uint16_t float_to_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = (bits >> 16) & 0x8000u;
  const std::uint32_t magnitude = bits & 0x7fffffffu;
  if (magnitude > 0x7f800000u) return static_cast<std::uint16_t>(sign | 0x7e00u);
  if (magnitude >= 0x477ff000u) return static_cast<std::uint16_t>(sign | 0x7c00u);  // values >= 65520 round to infinity
  if (magnitude < 0x38800000u) {  // 16-bit floats below 2^-14 are subnormal; after adding 1/2, the float unit rounds to
                                  // multiples of 2^-24
    const float shifted = std::bit_cast<float>(magnitude) + 0.5f;
    return static_cast<std::uint16_t>(sign | (std::bit_cast<std::uint32_t>(shifted) - 0x3f000000u));
  }
  const std::uint32_t odd = (magnitude >> 13) & 1u;
  return static_cast<std::uint16_t>(sign | ((magnitude - 0x38000000u + 0xfffu + odd) >> 13));
}

/// Returns the half nearest to a number, with ties to even. Numbers beyond the range of 16-bit floats are clamped to
/// 65504 or -65504. The function has no branches, so that the compiler can turn loops over it into vector instructions.
inline std::uint16_t clamped_to_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t magnitude = std::min(bits & 0x7fffffffu, 0x477fe000u);
  const std::uint32_t subnormal = std::bit_cast<std::uint32_t>(std::bit_cast<float>(magnitude) + 0.5f) - 0x3f000000u;
  const std::uint32_t normal = (magnitude - 0x38000000u + 0xfffu + (magnitude >> 13 & 1u)) >> 13;
  // Selects the value with bit operations. For a ?: operator, GCC 12 would make a branch around the float addition, and
  // would not use vector instructions.
  const std::uint32_t is_subnormal = 0u - static_cast<std::uint32_t>(magnitude < 0x38800000u);
  return static_cast<std::uint16_t>((bits >> 16 & 0x8000u) | (subnormal & is_subnormal) | (normal & ~is_subnormal));
}

/// Returns the value of a finite half.
inline float half_to_float(std::uint16_t bits) {
  const std::uint32_t magnitude = bits & 0x7fffu;
  // Subnormal values are multiples of 2^-24. For other values, the exponent is converted to the exponent of a float.
  const float value = magnitude < 0x400u ? static_cast<float>(magnitude) * 0x1p-24f
                                         : std::bit_cast<float>((magnitude << 13) + 0x38000000u);
  return (bits & 0x8000u) != 0 ? -value : value;
}

}  // namespace multum
