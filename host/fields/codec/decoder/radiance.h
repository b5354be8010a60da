// SPDX-License-Identifier: Apache-2.0
// Radiance of the gamma-coded values that chunks hold: value 255 is a radiance of 1, the exponent 2.2. Computed as
// x^2 x^(1/5), the root by a guess from the float's bits and two steps of Halley's method, r (2 r^5 + 3 x) / (3 r^5 +
// 2 x): within 6e-7 of the power, two thousand times less than a half's steps. Only +, *, / and bits: the same in every
// browser and library, and loops of it become vector instructions, where pow takes half of a texture's decoding.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace multum {

/// At least 0. Values beyond 1e4 times 255 count as that, and what is not a number may: far more than a half holds.
inline float radiance_of(float value) {
  // Below 1e-12 the radiance is 4e-27 or less, a half's 0; so the root is of a number that is neither 0 nor subnormal.
  // Bits of floats are in their order, and compilers make no branches of comparing them.
  constexpr auto kLeast = std::bit_cast<std::int32_t>(1e-12f), kMost = std::bit_cast<std::int32_t>(1e4f);
  const std::int32_t bits = std::min(std::max(std::bit_cast<std::int32_t>(value * (1.0f / 255.0f)), kLeast), kMost);
  const auto x = std::bit_cast<float>(bits);
  // A fifth of the logarithm: the exponent's bias times 4/5 is added again. 0x32cccccc would be exact at powers of 32.
  const float fifth = static_cast<float>(bits) * 0.2f;
  float r = std::bit_cast<float>(static_cast<std::int32_t>(fifth) + 0x32c80000);
  for (int step = 0; step < 2; ++step) {
    const float r5 = r * r * r * r * r;
    r *= (2.0f * r5 + 3.0f * x) / (3.0f * r5 + 2.0f * x);
  }
  return x * x * r;
}

}  // namespace multum
