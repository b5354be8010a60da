// SPDX-License-Identifier: Apache-2.0
// Estimates the probability of a binary symbol in one context from the symbols seen there: the mean of a fast and a
// slow exponential average. While a context is young both average over all it has seen (weight 1/(n + 1.5) of the nth
// symbol, the estimator of Krichevsky and Trofimov), so that contexts of a few dozen symbols learn as fast as can be:
// a texture has a few kilobytes for all its contexts. Integers alone: encoder and decoder agree on every machine.
#pragma once

#include <algorithm>
#include <cstdint>

namespace multum {

class AdaptiveBit {
 public:
  /// Of 1, in 1/65536; 32 to 65504, so that no symbol costs more than 11 bits.
  std::uint32_t probability() const {
    return std::clamp<std::uint32_t>((std::uint32_t{fast_} + slow_) / 2, kLeast, 65536 - kLeast);
  }

  void update(bool bit) {
    const int target = bit ? 65535 : 0;
    fast_ = moved(fast_, target, std::min<int>(count_, kFastCount));
    slow_ = moved(slow_, target, std::min<int>(count_, kSlowCount));
    if (count_ < kSlowCount) ++count_;
  }

 private:
  static constexpr std::uint32_t kLeast = 32;
  static constexpr int kFastCount = 20, kSlowCount = 160;  // symbols that the averages look back over at most

  static std::uint16_t moved(std::uint16_t average, int target, int count) {
    return static_cast<std::uint16_t>(average + (target - average) * 2 / (2 * count + 3));
  }

  std::uint16_t fast_ = 32768, slow_ = 32768;
  std::uint8_t count_ = 0;
};

}  // namespace multum
