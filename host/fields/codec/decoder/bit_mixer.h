// SPDX-License-Identifier: Apache-2.0
// Mixes the predictions of several contexts for the next symbol into one probability. The mix is a weighted sum of log
// odds whose weights are learnt from the symbols (logistic mixing: Mahoney 2005, "Adaptive weighing of context models
// for lossless data compression"). All arithmetic is done with integers, so that encoder and decoder agree on every
// machine.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace multum {

/// 65536 / (1 + exp(-i / 4)) for i = -32 to 32.
inline constexpr std::array<int, 65> kLogistic = {
    22,    28,    36,    47,    60,    77,    98,    126,   162,   208,   267,   342,   439,
    562,   720,   922,   1179,  1506,  1921,  2446,  3108,  3938,  4971,  6249,  7812,  9702,
    11955, 14595, 17625, 21025, 24743, 28693, 32768, 36843, 40793, 44511, 47911, 50941, 53581,
    55834, 57724, 59287, 60565, 61598, 62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974,
    65097, 65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508, 65514};
extern const std::array<std::int16_t, 4096> kLogOdds;  // one entry per sixteen probabilities

/// Converts log odds, in units of 1/256, to a probability in units of 1/65536, from 22 to 65514.
inline std::uint32_t probability_of(int log_odds) {
  const auto shifted = static_cast<std::uint32_t>(std::clamp(log_odds, -2048, 2047) + 2048);
  const std::uint32_t i = shifted / 64, rest = shifted % 64;
  return static_cast<std::uint32_t>(kLogistic[i]) +
         static_cast<std::uint32_t>(kLogistic[i + 1] - kLogistic[i]) * rest / 64;
}

/// Converts a probability p, in units of 1/65536 and up to 65535, to log odds ln(p / (1 - p)) in units of 1/256, from
/// -2048 to 2047. The result never decreases when p rises.
inline int log_odds(std::uint32_t probability) { return kLogOdds[std::min<std::uint32_t>(probability, 65535) / 16]; }

class BitMixer {
 public:
  static constexpr std::size_t kInputsMax = 4;

  /// Returns the probability of a 1, in units of 1/65536, from the log odds of at most kInputsMax contexts.
  std::uint32_t mix(std::span<const int> inputs) const {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < inputs.size(); ++i) sum += std::int64_t{weights_[i]} * inputs[i];
    return probability_of(static_cast<int>(std::clamp<std::int64_t>(sum / 65536, -2048, 2047)));
  }
  /// Learns from the symbol that followed when `mix` had returned `probability` for `inputs`.
  void update(std::span<const int> inputs, std::uint32_t probability, bool bit) {
    // The gradient of the code length with respect to weight i is (p - bit) inputs[i], in natural logarithms. Each step
    // is 1/128 of the gradient. Half or twice this rate changes the file size of field_demo1 by at most 0.2 %. The
    // product is below 2^27, because inputs are below 2^11.
    const int error = (bit ? 65535 : 0) - static_cast<int>(probability);
    for (std::size_t i = 0; i < inputs.size(); ++i)
      weights_[i] = std::clamp(weights_[i] + error * inputs[i] / (1 << 15), -(1 << 15), 1 << 19);
  }

 private:
  // Weights in 1/65536. The sum of the weights starts above 1, because contexts that agree are right more often than
  // each one predicts.
  std::array<std::int32_t, kInputsMax> weights_{26000, 26000, 26000, 26000};
};

}  // namespace multum
