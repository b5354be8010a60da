// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/lobes/lobe_rounding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "host/formats/asset/textures/lobe_texture.h"
#include "host/formats/asset/textures/scalar_block.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/half_bits.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kBlockSide = 4;
constexpr std::size_t kBlockTexels = 16, kScalarBytes = 8;  // sizes of a BC4 block
constexpr std::size_t kPaletteSize = 8;

// The nearest values below and above the wanted value that can be stored for a texel of a lobe.
struct StorablePair {
  float values[2];
  int codes[2];
  float wanted, weight;
};

// Returns the best combination. If bit j is set, lobe j uses the upper value. Tries all 2^n combinations, 16 for four
// lobes.
std::pair<unsigned, float> best_combination(const std::vector<StorablePair>& pairs, float sum, float sum_weight) {
  unsigned best = 0;
  float least = INFINITY;
  for (unsigned taken = 0; taken < 1u << pairs.size(); ++taken) {
    float rest = sum, error = 0.0f;
    for (std::size_t j = 0; j < pairs.size(); ++j) {
      const float value = pairs[j].values[taken >> j & 1u], difference = value - pairs[j].wanted;
      rest -= value;
      error += pairs[j].weight * difference * difference;
    }
    error += sum_weight * rest * rest;
    if (error < least) least = error, best = taken;
  }
  return {best, least};
}

float offset_at(const RoundedChannel& lobe, std::size_t texel) {
  return lobe.offset.empty() ? 0.0f : lobe.offset[texel];
}

// Returns the value of a texel as a share of the channel's range, from 0 to 1. A constant channel has no range.
float share_of(const RoundedChannel& lobe, std::size_t texel) {
  return (lobe.wanted[texel] - offset_at(lobe, texel) - lobe.low) / std::max(lobe.range, 1e-30f);
}

float value_of(const RoundedChannel& lobe, std::size_t texel, float share) {
  return lobe.low + lobe.range * share + offset_at(lobe, texel);
}

// Stores four half floats per texel. Half floats are exact enough to round each lobe independently.
class HalfRounding : public LobeRounding {
 public:
  HalfRounding(int lobe_count, std::size_t texels) : layers_(size_of(lobe_count)) {
    for (auto& bytes : layers_) bytes.resize(texels * kLobeChannels * sizeof(std::uint16_t));
  }

  void round(int channel, std::vector<RoundedChannel>& lobes, const std::vector<float>&, float) override {
    for (std::size_t j = 0; j < lobes.size(); ++j)
      for (std::size_t i = 0; i < lobes[j].wanted.size(); ++i) {
        const std::uint16_t half = clamped_to_half(share_of(lobes[j], i));
        std::memcpy(&layers_[j][sizeof half * (kLobeChannels * i + size_of(channel))], &half, sizeof half);
        lobes[j].wanted[i] = value_of(lobes[j], i, half_to_float(half));
      }
  }
  const std::vector<std::uint8_t>& layer(int lobe, int) const override { return layers_[size_of(lobe)]; }

 private:
  std::vector<std::vector<std::uint8_t>> layers_;
};

// Stores four bytes per texel.
class ByteRounding : public LobeRounding {
 public:
  ByteRounding(int lobe_count, std::size_t texels) : layers_(size_of(lobe_count)) {
    for (auto& bytes : layers_) bytes.resize(texels * kLobeChannels);
  }

  void round(int channel, std::vector<RoundedChannel>& lobes, const std::vector<float>& sums,
             float sum_weight) override {
    std::vector<StorablePair> pairs(lobes.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
      for (std::size_t j = 0; j < lobes.size(); ++j) {
        const float code = 255.0f * std::clamp(share_of(lobes[j], i), 0.0f, 1.0f);
        pairs[j].wanted = lobes[j].wanted[i];
        pairs[j].weight = lobes[j].weight[i];
        pairs[j].codes[0] = static_cast<int>(std::floor(code));
        pairs[j].codes[1] = static_cast<int>(std::ceil(code));
        for (int k = 0; k < 2; ++k)
          pairs[j].values[k] = value_of(lobes[j], i, static_cast<float>(pairs[j].codes[k]) / 255.0f);
      }
      const unsigned taken = best_combination(pairs, sums[i], sum_weight).first;
      for (std::size_t j = 0; j < lobes.size(); ++j) {
        const unsigned k = taken >> j & 1u;
        layers_[j][kLobeChannels * i + size_of(channel)] = static_cast<std::uint8_t>(pairs[j].codes[k]);
        lobes[j].wanted[i] = pairs[j].values[k];
      }
    }
  }
  const std::vector<std::uint8_t>& layer(int lobe, int) const override { return layers_[size_of(lobe)]; }

 private:
  std::vector<std::vector<std::uint8_t>> layers_;
};

// A BC4 block in which each texel can choose another one of the block's eight values.
class RechosenBlock {
 public:
  explicit RechosenBlock(std::uint8_t* block) : block_(block) {
    // A block with the texel codes 0 to 7 decodes to all eight values.
    std::array<std::uint8_t, kScalarBytes> all{};
    std::copy(block, block + 2, all.begin());
    std::uint64_t codes = 0;
    for (std::size_t c = 0; c < kPaletteSize; ++c) codes |= c << (3 * c);
    for (std::size_t b = 0; b < 3; ++b) all[2 + b] = static_cast<std::uint8_t>(codes >> (8 * b));
    const std::array<float, kBlockTexels> shown = decode_scalar_block(all.data());
    for (std::size_t c = 0; c < kPaletteSize; ++c) sorted_[c] = {shown[c], static_cast<int>(c)};
    std::sort(sorted_.begin(), sorted_.end());
    for (std::size_t b = 0; b < 6; ++b) codes_ |= std::uint64_t{block[2 + b]} << (8 * b);
  }

  void look_up(float share, StorablePair& pair) const {
    std::size_t above = 0;
    while (above + 1 < kPaletteSize && sorted_[above].first < share) ++above;
    const std::size_t below = above > 0 && sorted_[above].first > share ? above - 1 : above;
    pair.values[0] = sorted_[below].first;
    pair.values[1] = sorted_[above].first;
    pair.codes[0] = sorted_[below].second;
    pair.codes[1] = sorted_[above].second;
  }
  void set(std::size_t texel, int code) {
    codes_ &= ~(std::uint64_t{7} << (3 * texel));
    codes_ |= static_cast<std::uint64_t>(code) << (3 * texel);
  }
  void write() const {
    for (std::size_t b = 0; b < 6; ++b) block_[2 + b] = static_cast<std::uint8_t>(codes_ >> (8 * b));
  }

 private:
  std::uint8_t* block_;
  std::array<std::pair<float, int>, kPaletteSize> sorted_;
  std::uint64_t codes_ = 0;
};

// Stores two BC5 layers per lobe, with one BC4 block per channel. First, for one lobe after the other, chooses the
// endpoints of blocks so that they compensate the errors of all other lobes. Then chooses, for all lobes together,
// which value of its block each texel uses.
class BlockRounding : public LobeRounding {
 public:
  BlockRounding(BlockEncoder& encoder, int lobe_count, int width, int row_count)
      : encoder_(encoder), width_(width), row_count_(row_count), layers_(2 * size_of(lobe_count)) {
    for (auto& bytes : layers_) bytes.resize(layer_bytes(LobeTexels::kBlocks, width, row_count));
  }

  void round(int channel, std::vector<RoundedChannel>& lobes, const std::vector<float>& sums,
             float sum_weight) override {
    // Each block begins with the endpoints that fit its own lobe's values best.
    std::vector<Encoded> all;
    for (const RoundedChannel& lobe : lobes) all.push_back(encoded(lobe, lobe.wanted));
    for (std::size_t j = 0; j < lobes.size(); ++j) make_up(j, lobes, sums, sum_weight, all);
    std::size_t at = 0;
    for (int y = 0; y < row_count_; y += kBlockSide)
      for (int x = 0; x < width_; x += kBlockSide, at += kScalarBytes)
        round_block({x, y, at}, all, lobes, sums, sum_weight);
    for (std::size_t j = 0; j < lobes.size(); ++j) {
      lobes[j].wanted = all[j].values;
      std::uint8_t* to = layers_[2 * j + size_of(channel / 2)].data() + kScalarBytes * size_of(channel % 2);
      for (std::size_t b = 0; b < at; b += kScalarBytes, to += 2 * kScalarBytes)
        std::memcpy(to, &all[j].blocks[b], kScalarBytes);
    }
  }
  const std::vector<std::uint8_t>& layer(int lobe, int layer) const override {
    return layers_[2 * size_of(lobe) + size_of(layer)];
  }

 private:
  struct BlockPlace {
    int x, y;
    std::size_t at;  // index in the blocks of a lobe
  };

  struct Encoded {
    std::vector<std::uint8_t> blocks;
    std::vector<float> values;  // values in the block
  };

  template <typename Look>
  void each_texel(int x, int y, const Look& look) const {
    for (int row = 0; row < std::min(kBlockSide, row_count_ - y); ++row)
      for (int column = 0; column < std::min(kBlockSide, width_ - x); ++column)
        look(size_of(y + row) * size_of(width_) + size_of(x + column), size_of(kBlockSide * row + column));
  }

  Encoded encoded(const RoundedChannel& lobe, const std::vector<float>& wanted) const {
    Encoded made;
    std::vector<glm::vec4> texels(wanted.size(), glm::vec4(0.0f));
    for (std::size_t i = 0; i < texels.size(); ++i)
      texels[i].x = (wanted[i] - offset_at(lobe, i) - lobe.low) / std::max(lobe.range, 1e-30f);
    made.blocks = encoder_.encode(TexelFormat::kBc4, width_, row_count_, texels);
    made.values.resize(wanted.size());
    const std::uint8_t* block = made.blocks.data();
    for (int y = 0; y < row_count_; y += kBlockSide)
      for (int x = 0; x < width_; x += kBlockSide, block += kScalarBytes) {
        const auto shares = decode_scalar_block(block);
        each_texel(x, y, [&](std::size_t i, std::size_t k) { made.values[i] = value_of(lobe, i, shares[k]); });
      }
    return made;
  }

  // Encodes lobe `j` again so that it compensates the errors of the other lobes. Each block keeps the better result.
  void make_up(std::size_t j, const std::vector<RoundedChannel>& lobes, const std::vector<float>& sums,
               float sum_weight, std::vector<Encoded>& all) const {
    const RoundedChannel& lobe = lobes[j];
    std::vector<float> rest = sums, wanted(sums.size());
    for (std::size_t k = 0; k < all.size(); ++k)
      if (k != j)
        for (std::size_t i = 0; i < rest.size(); ++i) rest[i] -= all[k].values[i];
    for (std::size_t i = 0; i < rest.size(); ++i)
      wanted[i] = (lobe.weight[i] * lobe.wanted[i] + sum_weight * rest[i]) / (lobe.weight[i] + sum_weight);
    const Encoded again = encoded(lobe, wanted);
    const auto error = [&](const Encoded& one, std::size_t i) {
      const float own = one.values[i] - lobe.wanted[i], sum = one.values[i] - rest[i];
      return lobe.weight[i] * own * own + sum_weight * sum * sum;
    };
    std::size_t at = 0;
    for (int y = 0; y < row_count_; y += kBlockSide)
      for (int x = 0; x < width_; x += kBlockSide, at += kScalarBytes) {
        float before = 0.0f, after = 0.0f;
        each_texel(x, y, [&](std::size_t i, std::size_t) { before += error(all[j], i), after += error(again, i); });
        if (after >= before) continue;
        std::memcpy(&all[j].blocks[at], &again.blocks[at], kScalarBytes);
        each_texel(x, y, [&](std::size_t i, std::size_t) { all[j].values[i] = again.values[i]; });
      }
  }

  void round_block(const BlockPlace& place, std::vector<Encoded>& all, const std::vector<RoundedChannel>& lobes,
                   const std::vector<float>& sums, float sum_weight) const {
    std::vector<RechosenBlock> chosen;
    for (Encoded& one : all) chosen.emplace_back(&one.blocks[place.at]);
    std::vector<StorablePair> pairs(lobes.size());
    each_texel(place.x, place.y, [&](std::size_t i, std::size_t texel) {
      float rest = sums[i], before = 0.0f;
      for (std::size_t j = 0; j < lobes.size(); ++j) {
        chosen[j].look_up(share_of(lobes[j], i), pairs[j]);
        pairs[j].wanted = lobes[j].wanted[i];
        pairs[j].weight = lobes[j].weight[i];
        for (float& value : pairs[j].values) value = value_of(lobes[j], i, value);
        const float d = all[j].values[i] - lobes[j].wanted[i];
        before += pairs[j].weight * d * d, rest -= all[j].values[i];
      }
      before += sum_weight * rest * rest;
      const auto [taken, after] = best_combination(pairs, sums[i], sum_weight);
      if (after >= before) return;
      for (std::size_t j = 0; j < lobes.size(); ++j) {
        const unsigned k = taken >> j & 1u;
        chosen[j].set(texel, pairs[j].codes[k]);
        all[j].values[i] = pairs[j].values[k];
      }
    });
    for (const RechosenBlock& block : chosen) block.write();
  }

  BlockEncoder& encoder_;
  const int width_, row_count_;
  std::vector<std::vector<std::uint8_t>> layers_;
};

}  // namespace

std::unique_ptr<LobeRounding> make_lobe_rounding(LobeTexels texels, BlockEncoder& encoder, int lobe_count, int width,
                                                 int row_count) {
  const std::size_t count = size_of(width) * size_of(row_count);
  switch (texels) {
    case LobeTexels::kRgba16f: return std::make_unique<HalfRounding>(lobe_count, count);
    case LobeTexels::kRgba8: return std::make_unique<ByteRounding>(lobe_count, count);
    case LobeTexels::kBlocks: return std::make_unique<BlockRounding>(encoder, lobe_count, width, row_count);
  }
  MULTUM_CHECK(false);
}

}  // namespace multum
