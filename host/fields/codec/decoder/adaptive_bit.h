// SPDX-License-Identifier: Apache-2.0
// Estimates the probability of a binary symbol in one context from the earlier symbols in this context. The estimate is
// the mean of a fast and a slow exponential average. In a context with few symbols, both averages cover all symbols.
// The nth symbol has the weight 1/(n + 1.5), as in the estimator of Krichevsky and Trofimov. Contexts with a few dozen
// symbols then learn as fast as possible. Fast learning matters because a texture has only a few kilobytes for all its
// contexts. All arithmetic is done with integers, so that encoder and decoder agree on every machine.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace multum {

class AdaptiveBit {
 public:
  /// Returns the probability of a 1, in units of 1/65536. The probability is 32 to 65504, so that no symbol costs more
  /// than 11 bits.
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
  static constexpr std::size_t kFastCount = 20, kSlowCount = 160;  // most symbols that each average covers

  /// Entry n is ceil(2^26 / (2 n + 3)). For x up to 131070, the product of entry n and x, divided by 2^26 and rounded
  /// down, equals x / (2 n + 3) rounded down. The result is exact, because an entry exceeds the exact quotient by less
  /// than 1, and 131070 * 323 is below 2^26. The table avoids divisions, which would take a third of the decoding time.
  static constexpr auto kReciprocals = [] {
    std::array<std::uint64_t, kSlowCount + 1> table{};
    for (std::size_t n = 0; n < table.size(); ++n) table[n] = ((std::uint64_t{1} << 26) + 2 * n + 2) / (2 * n + 3);
    return table;
  }();

  /// Moves an average towards 65535 or 0 by 2 / (2 count + 3) of the distance.
  static std::uint16_t moved(std::uint16_t average, bool bit, std::size_t count) {
    const std::uint64_t way = 2u * (bit ? 65535u - average : average);
    const auto step = static_cast<std::uint32_t>(way * kReciprocals[count] >> 26);
    return static_cast<std::uint16_t>(bit ? average + step : average - step);
  }

  std::uint16_t fast_ = 32768, slow_ = 32768;
  std::uint8_t count_ = 0;
};

}  // namespace multum
