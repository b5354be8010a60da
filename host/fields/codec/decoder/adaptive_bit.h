// SPDX-License-Identifier: Apache-2.0
// Estimates the probability of a binary symbol in one context from the symbols seen there: the mean of a fast and a
// slow exponential average. While a context is young both average over all it has seen (weight 1/(n + 1.5) of the nth
// symbol, the estimator of Krichevsky and Trofimov), so that contexts of a few dozen symbols learn as fast as can be:
// a texture has a few kilobytes for all its contexts. Integers alone: encoder and decoder agree on every machine.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace multum {

class AdaptiveBit {
 public:
  /// Of 1, in 1/65536; 32 to 65504, so that no symbol costs more than 11 bits.
  std::uint32_t probability() const {
    return std::clamp<std::uint32_t>((std::uint32_t{fast_} + slow_) / 2, kLeast, 65536 - kLeast);
  }

  void update(bool bit) {
    fast_ = moved(fast_, bit, std::min<std::size_t>(count_, kFastCount));
    slow_ = moved(slow_, bit, std::min<std::size_t>(count_, kSlowCount));
    if (count_ < kSlowCount) ++count_;
  }

 private:
  static constexpr std::uint32_t kLeast = 32;
  static constexpr std::size_t kFastCount = 20, kSlowCount = 160;  // symbols that the averages look back over at most

  /// ceil(2^26 / (2 n + 3)): times x, over 2^26, it is x / (2 n + 3) rounded down for x up to 131070, since it is above
  /// the quotient by less than 1, and 131070 * 323 is below 2^26. A third of the time of decoding were divisions.
  static constexpr auto kReciprocals = [] {
    std::array<std::uint64_t, kSlowCount + 1> table{};
    for (std::size_t n = 0; n < table.size(); ++n) table[n] = ((std::uint64_t{1} << 26) + 2 * n + 2) / (2 * n + 3);
    return table;
  }();

  /// Towards 65535 or 0 by 2 / (2 count + 3) of the way.
  static std::uint16_t moved(std::uint16_t average, bool bit, std::size_t count) {
    const std::uint64_t way = 2u * (bit ? 65535u - average : average);
    const auto step = static_cast<std::uint32_t>(way * kReciprocals[count] >> 26);
    return static_cast<std::uint16_t>(bit ? average + step : average - step);
  }

  std::uint16_t fast_ = 32768, slow_ = 32768;
  std::uint8_t count_ = 0;
};

}  // namespace multum
