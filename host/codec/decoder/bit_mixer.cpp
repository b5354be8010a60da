// SPDX-License-Identifier: Apache-2.0
#include "host/codec/decoder/bit_mixer.h"

#include <algorithm>

namespace multum {
namespace {

constexpr int kOddsStep = 64;  // of the table below, in 1/256

/// 65536 / (1 + exp(-i / 4)) for i = -32 to 32.
constexpr std::array<int, 65> kLogistic = {22,    28,    36,    47,    60,    77,    98,    126,   162,   208,   267,
                                           342,   439,   562,   720,   922,   1179,  1506,  1921,  2446,  3108,  3938,
                                           4971,  6249,  7812,  9702,  11955, 14595, 17625, 21025, 24743, 28693, 32768,
                                           36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287, 60565, 61598,
                                           62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974, 65097, 65194, 65269,
                                           65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508, 65514};

constexpr int interpolated_logistic(int odds) {
  const int shifted = std::clamp(odds, -2048, 2047) + 2048;
  const auto i = static_cast<std::size_t>(shifted / kOddsStep);
  return kLogistic[i] + (kLogistic[i + 1] - kLogistic[i]) * (shifted % kOddsStep) / kOddsStep;
}

/// The least odds whose logistic is at least the middle of each sixteen probabilities.
const std::array<std::int16_t, 4096>& odds_table() {
  static const auto table = [] {
    std::array<std::int16_t, 4096> odds{};
    int x = -2048;
    for (std::size_t i = 0; i < odds.size(); ++i) {
      while (x < 2047 && interpolated_logistic(x) < static_cast<int>(i * 16 + 8)) ++x;
      odds[i] = static_cast<std::int16_t>(x);
    }
    return odds;
  }();
  return table;
}

}  // namespace

int log_odds(std::uint32_t probability) { return odds_table()[std::min<std::uint32_t>(probability, 65535) / 16]; }

std::uint32_t probability_of(int log_odds) { return static_cast<std::uint32_t>(interpolated_logistic(log_odds)); }

std::uint32_t BitMixer::mix(std::span<const int> inputs) const {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i) sum += std::int64_t{weights_[i]} * inputs[i];
  return probability_of(static_cast<int>(std::clamp<std::int64_t>(sum / 65536, -2048, 2047)));
}

void BitMixer::update(std::span<const int> inputs, std::uint32_t probability, bool bit) {
  // The gradient of the code length by weight i is (p - bit) inputs[i]; a step of 1/128 of it, in natural logarithms.
  // Half or twice as much makes files of field_demo1 at most 0.2 % longer or shorter.
  const std::int64_t error = (bit ? 65535 : 0) - static_cast<std::int64_t>(probability);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const std::int64_t step = error * inputs[i] / (std::int64_t{1} << 15);
    weights_[i] = static_cast<std::int32_t>(std::clamp<std::int64_t>(weights_[i] + step, -(1 << 15), 1 << 19));
  }
}

}  // namespace multum
