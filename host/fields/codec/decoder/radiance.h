// SPDX-License-Identifier: Apache-2.0
// Converts the gamma-coded values of chunks to radiance. The value 255 is a radiance of 1, and the exponent is 2.2. The
// power is computed as x^2 x^(1/5). The root starts from a guess based on the float's bits. Two steps of Halley's
// method, r (2 r^5 + 3 x) / (3 r^5 + 2 x), refine the root. The error is at most 6e-7, which is two thousand times
// smaller than a step of a 16-bit float. The code uses only +, *, / and operations on bits, so that all browsers and
// libraries agree. The compiler can vectorize it. A call of pow() instead would take half of a texture's decoding time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace multum {

/// Returns a radiance of at least 0. Values above 1e4 * 255, and possibly NaN, are replaced by this limit, which is far
/// more than a 16-bit float can hold.
inline float radiance_of(float value) {
  // The value is raised to at least 1e-12, so that the root's argument is never 0 or subnormal. Below this limit the
  // radiance is at most 4e-27, which a 16-bit float stores as 0. Positive floats have the same order as their bits, and
  // comparisons of bits compile without branches.
  constexpr auto kLeast = std::bit_cast<std::int32_t>(1e-12f), kMost = std::bit_cast<std::int32_t>(1e4f);
  const std::int32_t bits = std::min(std::max(std::bit_cast<std::int32_t>(value * (1.0f / 255.0f)), kLeast), kMost);
  const auto x = std::bit_cast<float>(bits);
  // Divides the logarithm by 5. The constant restores 4/5 of the exponent's bias. (The constant 0x32cccccc would be
  // exact at powers of 32.)
  const float fifth = static_cast<float>(bits) * 0.2f;
  float r = std::bit_cast<float>(static_cast<std::int32_t>(fifth) + 0x32c80000);
  for (int step = 0; step < 2; ++step) {
    const float r5 = r * r * r * r * r;
    r *= (2.0f * r5 + 3.0f * x) / (3.0f * r5 + 2.0f * x);
  }
  return x * x * r;
}

}  // namespace multum
