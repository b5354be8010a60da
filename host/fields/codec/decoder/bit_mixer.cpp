// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/bit_mixer.h"

namespace multum {
namespace {

/// For each group of sixteen probabilities, finds the lowest log odds whose logistic is at least the middle probability
/// of the group.
std::array<std::int16_t, 4096> make_odds_table() {
  std::array<std::int16_t, 4096> odds{};
  int x = -2048;
  for (std::size_t i = 0; i < odds.size(); ++i) {
    while (x < 2047 && probability_of(x) < i * 16 + 8) ++x;
    odds[i] = static_cast<std::int16_t>(x);
  }
  return odds;
}

}  // namespace

const std::array<std::int16_t, 4096> kLogOdds = make_odds_table();

}  // namespace multum
