// SPDX-License-Identifier: Apache-2.0
// Computes exp() in loops that the compiler turns into vector instructions (host/foundation/base/vector_clones.h). The
// result has the same bits on every machine, unlike the result of the C library.
#pragma once

#include <bit>
#include <cstdint>

namespace multum {

/// Returns exp(x) for x <= 0, and exp(-700) for smaller x. The relative error is at most 4e-16. Splits x into n ln 2 +
/// r with |r| <= ln 2 / 2, and multiplies 2^n by the Taylor series of degree 13, whose remainder is at most 5e-18.
inline double exp_of_negative(double x) {
  constexpr double kInverseLn2 = 1.4426950408889634, kLn2High = 6.93147180369123816490e-01,
                   kLn2Low = 1.90821492927058770002e-10, kToInteger = 6755399441055744.0;  // 1.5 * 2^52
  const double bounded = x > -700.0 ? x : -700.0;
  const double shifted = bounded * kInverseLn2 + kToInteger;
  const double n = shifted - kToInteger;
  const double r = (bounded - n * kLn2High) - n * kLn2Low;
  double p = 1.0 / 6227020800.0;
  p = p * r + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0;
  p = p * r + 1.0 / 3628800.0;
  p = p * r + 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  p = p * r + 1.0;
  p = p * r + 1.0;
  // The low bits of `shifted` are n. Adding them to the exponent of p multiplies p by 2^n.
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(p) + (std::bit_cast<std::uint64_t>(shifted) << 52));
}

}  // namespace multum
