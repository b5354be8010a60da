// SPDX-License-Identifier: Apache-2.0
// Mixes what several contexts say of the next symbol into one probability: a weighted sum of their log odds, the
// weights learnt from the symbols themselves (logistic mixing: Mahoney 2005, "Adaptive weighing of context models for
// lossless data compression"). Integers alone: encoder and decoder agree on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace multum {

/// ln(p / (1 - p)) in 1/256 of a probability in 1/65536, up to 65535: -2048 to 2047. Never falls as p rises.
int log_odds(std::uint32_t probability);
/// The probability in 1/65536 of log odds in 1/256: 22 to 65514.
std::uint32_t probability_of(int log_odds);

class BitMixer {
 public:
  static constexpr std::size_t kInputsMax = 4;

  /// Probability of 1, in 1/65536, from the log odds that each context gives, at most kInputsMax.
  std::uint32_t mix(std::span<const int> inputs) const;
  /// Learns from the symbol that came after `mix` had given `probability` for `inputs`.
  void update(std::span<const int> inputs, std::uint32_t probability, bool bit);

 private:
  // In 1/65536. Their sum starts above 1: contexts that agree are right more often than each of them says.
  std::array<std::int32_t, kInputsMax> weights_{26000, 26000, 26000, 26000};
};

}  // namespace multum
