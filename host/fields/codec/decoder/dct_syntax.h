// SPDX-License-Identifier: Apache-2.0
// Codes the quantized cosine coefficients of an image's blocks in groups of 4 x 4 blocks. Each group has a flag that is
// set if any of its blocks has values; in that case the blocks follow. Each block has such a flag too, and one flag for
// each band, the lowest first. A band with values stores the significance, magnitude and sign of each coefficient. Band
// 0 is the constant. Band k has the frequencies whose larger index is in [2^(k-1), 2^k):
//
//      0 1 2 2 3 ...      u
//      1 1 2 2 3
//      2 2 2 2 3          Contexts: the values of the blocks to the left and above, of the same block in the
//      2 2 2 2 3          pyramid's coarser image, of the same block of luma, and of neighbouring lower frequencies.
//      3 3 3 3 3
//      v
#pragma once

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "host/fields/codec/decoder/coefficient_blocks.h"
#include "host/fields/codec/decoder/context_table.h"
#include "host/fields/codec/decoder/symbol_coder.h"

namespace multum {

/// The coded blocks around a block. An empty span stands for a block of zeros, or for a missing block.
struct BlockSurroundings {
  std::span<const std::int16_t> left, up, parent, luma;
  bool has_parent = false;
  std::size_t plane = 0;  // plane 0 is luma
  std::size_t level = 0;  // level of the pyramid; 0 is the coarsest
};

/// The coded groups around a group of blocks.
struct GroupSurroundings {
  std::size_t beside = 0;  // number of neighbouring groups (left, above) with values: 0 to 2
  bool has_parent = false;
  bool parent = false, before = false, luma = false;  // whether the same group has values in the parent, in the image
                                                      // coded before, and in luma
  std::size_t plane = 0, level = 0;                   // as in BlockSurroundings
};

class DctSyntax {
 public:
  /// is_dct_side() must accept `side`.
  explicit DctSyntax(int side) : side_(static_cast<std::size_t>(side)), band_count_(width_of(side_)) {
    for (std::size_t v = 0; v < side_; ++v)
      for (std::size_t u = 0; u < side_; ++u) {
        const std::size_t band = width_of(std::max(u, v));
        order_[band].push_back(static_cast<std::uint16_t>(v * side_ + u));
      }
    for (auto& band : order_)  // sorts by ascending frequency, so that lower neighbours come first
      std::stable_sort(band.begin(), band.end(), [this](auto a, auto b) { return frequency(a) < frequency(b); });
  }

  std::size_t band_count() const { return band_count_; }
  /// Returns the places v * side + u of band k.
  std::span<const std::uint16_t> band(std::size_t k) const { return order_[k]; }

  /// Codes whether a group contains any coded block.
  template <class Port>
  bool group(SymbolCoder<Port>& coder, bool any, const GroupSurroundings& around) {
    const std::size_t chroma = around.plane > 0 ? 1 : 0, level = std::min<std::size_t>(around.level, 3);
    const std::size_t parent = !around.has_parent ? 2 : around.parent ? 1 : 0, before = around.before ? 1 : 0;
    return coder.bit(any,
                     {&group_a_[chroma][around.beside][parent][before],
                      &group_b_[around.plane][level][around.luma ? 1 : 0], &group_c_[chroma][level][around.beside]},
                     group_mixer_[chroma]);
  }

  /// Codes `values`, which has side * side numbers. When decoding, they must be zero before the call. Returns whether
  /// any value is coded. Set `is_coded` if at least one value is known to be coded.
  template <class Port>
  bool block(SymbolCoder<Port>& coder, std::span<std::int16_t> values, const BlockSurroundings& around,
             bool is_coded = false) {
    const std::size_t chroma = around.plane > 0 ? 1 : 0, level = std::min<std::size_t>(around.level, 3);
    const std::size_t parent = !around.has_parent ? 2 : around.parent.empty() ? 0 : 1;
    const std::size_t beside = (around.left.empty() ? 0u : 1u) + (around.up.empty() ? 0u : 1u);
    std::array<bool, kBands> has{};
    bool any = is_coded;
    if constexpr (!Port::kDecodes)
      for (std::size_t k = 0; k < band_count_; ++k) any |= has[k] = has_band(values, k);
    if (!is_coded)
      any = coder.bit(any,
                      {&coded_a_[chroma][beside][parent], &coded_b_[around.plane][level][around.luma.empty() ? 0 : 1],
                       &coded_c_[chroma][level][beside]},
                      coded_mixer_[chroma]);
    if (!any) return false;
    bool before = false;
    for (std::size_t k = 0; k < band_count_; ++k) {
      if (k + 1 < band_count_ || before) {
        const std::size_t sides = (has_band(around.left, k) ? 1u : 0u) + (has_band(around.up, k) ? 1u : 0u);
        const std::size_t above = !around.has_parent ? 2 : has_band(around.parent, k) ? 1 : 0;
        const std::size_t previous = k == 0 ? 0 : has[k - 1] ? 2 : before ? 1 : 0;
        has[k] = coder.bit(has[k],
                           {&band_a_[chroma][k][previous][above], &band_b_[chroma][k][sides][previous],
                            &band_c_[around.plane][k][has_band(around.luma, k) ? 1 : 0][level]},
                           band_mixer_[chroma][k]);
      } else {
        has[k] = true;  // some band has values
      }
      if (has[k]) coefficients(coder, values, around, k);
      before |= has[k];
    }
    return true;
  }

 private:
  static constexpr std::size_t kBands = 6;
  static constexpr int kUnary = 14;  // larger magnitudes are written as a number

  /// std::bit_width returns the type of its argument before GCC 14, and int from then on.
  static std::size_t width_of(std::size_t number) { return static_cast<std::size_t>(std::bit_width(number)); }

  std::size_t frequency(std::size_t place) const { return place / side_ + place % side_; }

  bool has_band(std::span<const std::int16_t> values, std::size_t k) const {
    return !values.empty() && std::any_of(order_[k].begin(), order_[k].end(), [&](auto at) { return values[at] != 0; });
  }

  static std::size_t magnitude_at(std::span<const std::int16_t> values, std::size_t at) {
    return values.empty() ? 0 : static_cast<std::size_t>(std::abs(values[at]));
  }

  /// Returns the sum of the magnitudes of adjacent lower frequencies. The nearest one counts twice.
  std::size_t lower_neighbours(std::span<const std::int16_t> values, std::size_t at) const {
    const std::size_t u = at % side_, v = at / side_;
    std::size_t sum = 0;
    if (u > 0) sum += 2 * magnitude_at(values, at - 1);
    if (v > 0) sum += 2 * magnitude_at(values, at - side_);
    if (u > 0 && v > 0) sum += magnitude_at(values, at - side_ - 1);
    if (u > 1) sum += magnitude_at(values, at - 2);
    if (v > 1) sum += magnitude_at(values, at - 2 * side_);
    return sum;
  }

  template <class Port>
  void coefficients(SymbolCoder<Port>& coder, std::span<std::int16_t> values, const BlockSurroundings& around,
                    std::size_t k) {
    const std::size_t chroma = around.plane > 0 ? 1 : 0, level = std::min<std::size_t>(around.level, 3);
    std::size_t found = 0;
    for (const std::uint16_t at : order_[k]) {
      const std::size_t u = at % side_, v = at / side_;
      const std::size_t parent = std::min<std::size_t>(magnitude_at(around.parent, at), 2);
      const std::size_t luma = std::min<std::size_t>(magnitude_at(around.luma, at), 2);
      const std::size_t lower = lower_neighbours(values, at);
      const std::size_t near = std::min<std::size_t>(lower, 7);
      const std::size_t sides = std::min<std::size_t>(magnitude_at(around.left, at) + magnitude_at(around.up, at), 3);
      const std::size_t place = width_of(u) * kBands + width_of(v);
      bool significant = values[at] != 0;
      if (found > 0 || at != order_[k].back())
        significant = coder.bit(significant,
                                {&significant_a_[chroma][place][parent], &significant_b_[chroma][k][near][luma],
                                 &significant_c_[chroma][k][sides][std::min<std::size_t>(found, 3)],
                                 &significant_d_[chroma][level][std::min<std::size_t>(frequency(at), 31)]},
                                significant_mixer_[chroma][k]);
      else significant = true;
      if (!significant) continue;
      ++found;
      const int magnitude = coded_magnitude(coder, std::abs(values[at]), chroma, k, lower, parent + sides);
      values[at] = static_cast<std::int16_t>(coded_sign(coder, values[at] < 0, around, at) ? -magnitude : magnitude);
    }
  }

  template <class Port>
  int coded_magnitude(SymbolCoder<Port>& coder, int magnitude, std::size_t chroma, std::size_t k, std::size_t lower,
                      std::size_t beside) {
    const std::size_t near = std::min<std::size_t>(lower / 2, 5), side = std::min<std::size_t>(beside, 4);
    int coded = 1;
    while (coded < kUnary) {
      const auto step = static_cast<std::size_t>(coded - 1);
      if (!coder.bit(
              magnitude > coded,
              {&larger_a_[chroma][k][std::min<std::size_t>(step, 3)], &larger_b_[near][step], &larger_c_[side][step]},
              larger_mixer_))
        return coded;
      ++coded;
    }
    const auto above = static_cast<std::uint32_t>(std::max(magnitude - kUnary, 0));
    const int rest = static_cast<int>(coder.number(above, escape_));
    return std::min(kUnary + rest, CoefficientBlocks::kMagnitudeMax);
  }

  template <class Port>
  bool coded_sign(SymbolCoder<Port>& coder, bool negative, const BlockSurroundings& around, std::size_t at) {
    if (at != 0) return coder.even_bit(negative);
    const auto sign = [](std::span<const std::int16_t> values) -> std::size_t {
      return values.empty() || values[0] == 0 ? 0 : values[0] > 0 ? 1 : 2;
    };
    return coder.bit(negative, sign_[around.plane > 0 ? 1 : 0][sign(around.left)][sign(around.up)]);
  }

  std::size_t side_;
  std::size_t band_count_;
  std::array<std::vector<std::uint16_t>, kBands> order_;

  ContextTable<2, 3, 3, 2> group_a_;
  ContextTable<3, 4, 2> group_b_;
  ContextTable<2, 4, 3> group_c_;
  ContextTable<2, 3, 3> coded_a_;
  ContextTable<3, 4, 2> coded_b_;
  ContextTable<2, 4, 3> coded_c_;
  ContextTable<2, kBands, 3, 3> band_a_, band_b_;
  ContextTable<3, kBands, 2, 4> band_c_;
  ContextTable<2, kBands * kBands, 3> significant_a_;
  ContextTable<2, kBands, 8, 3> significant_b_;
  ContextTable<2, kBands, 4, 4> significant_c_;
  ContextTable<2, 4, 32> significant_d_;
  ContextTable<2, kBands, 4> larger_a_;
  ContextTable<6, kUnary> larger_b_;
  ContextTable<5, kUnary> larger_c_;
  ContextTable<2, 3, 3> sign_;
  std::array<AdaptiveBit, 17> escape_;
  std::array<BitMixer, 2> group_mixer_, coded_mixer_;
  std::array<std::array<BitMixer, kBands>, 2> band_mixer_, significant_mixer_;
  BitMixer larger_mixer_;
};

}  // namespace multum
