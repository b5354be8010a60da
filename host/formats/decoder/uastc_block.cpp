// SPDX-License-Identifier: Apache-2.0
// Layout of a block, from its lowest bit:
//
//   code of the mode | hints for other encoders (ignored) | [partition] [channel of the second plane]
//   | trits or quints of the endpoints, 5 or 3 per number | their lower bits
//   | weights; the first weight of a subset has one bit less
//
// Endpoints and weights then have the same meaning as in ASTC ("Khronos Data Format Specification", 23.15 to 23.21).
#include "host/formats/decoder/uastc_block.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace multum {
namespace {

constexpr std::size_t kTexels = 16;

struct UastcMode {
  unsigned code, code_bits, hint_bits;
  unsigned components, subsets, planes, weight_bits;
  unsigned endpoint_bits, endpoint_base;  // values are below base << bits; base 1 has only bits, base 3 trits, and base
                                          // 5 quints
};

constexpr unsigned kSolidMode = 8;
constexpr std::array<UastcMode, 19> kUastcModes = {{{0x01, 4, 15, 3, 1, 1, 4, 6, 3},
                                                    {0x35, 6, 15, 3, 1, 1, 2, 8, 1},
                                                    {0x1D, 5, 15, 3, 2, 1, 3, 4, 1},
                                                    {0x03, 5, 15, 3, 3, 1, 2, 2, 3},
                                                    {0x13, 5, 15, 3, 2, 1, 2, 3, 5},
                                                    {0x0B, 5, 15, 3, 1, 1, 3, 8, 1},
                                                    {0x1B, 5, 15, 3, 1, 2, 2, 5, 5},
                                                    {0x07, 5, 15, 3, 2, 1, 2, 3, 5},
                                                    {0x17, 5, 0, 4, 0, 0, 0, 0, 1},
                                                    {0x0F, 5, 23, 4, 2, 1, 2, 4, 1},
                                                    {0x02, 3, 17, 4, 1, 1, 4, 4, 3},
                                                    {0x00, 2, 17, 4, 1, 2, 2, 4, 3},
                                                    {0x06, 3, 17, 4, 1, 1, 3, 6, 3},
                                                    {0x1F, 5, 23, 4, 1, 2, 1, 8, 1},
                                                    {0x0D, 5, 23, 4, 1, 1, 2, 8, 1},
                                                    {0x05, 7, 23, 2, 1, 1, 4, 8, 1},
                                                    {0x15, 6, 23, 2, 2, 1, 2, 8, 1},
                                                    {0x25, 6, 23, 2, 1, 2, 2, 8, 1},
                                                    {0x09, 4, 15, 3, 1, 1, 5, 5, 1}}};

// Seeds of ASTC's partitions. The first table is for two subsets. The second is for the two subsets of mode 7, which
// are also in BC7's modes with three subsets. The third is for three subsets.
constexpr std::array<unsigned, 30> kSeedsOfTwo = {28,  20,  16,  29,  91,  9,   107, 72,  149, 204,
                                                  50,  114, 496, 17,  78,  39,  252, 828, 43,  156,
                                                  116, 210, 476, 273, 684, 359, 246, 195, 694, 524};
constexpr std::array<unsigned, 19> kSeedsOfMode7 = {36,  48,  61,  137, 161, 183, 226, 281, 302, 307,
                                                    479, 495, 593, 594, 605, 799, 812, 988, 993};
constexpr std::array<unsigned, 11> kSeedsOfThree = {260, 74, 32, 156, 183, 15, 745, 0, 335, 902, 254};

class BitReader {
 public:
  explicit BitReader(const std::uint8_t* bytes) : bytes_(bytes) {}
  void skip(unsigned count) { at_ += count; }
  unsigned take(unsigned count) {
    unsigned value = 0;
    for (unsigned i = 0; i < count; ++i, ++at_) value |= static_cast<unsigned>(bytes_[at_ / 8] >> at_ % 8 & 1) << i;
    return value;
  }

 private:
  const std::uint8_t* bytes_;
  unsigned at_ = 0;
};

std::uint32_t hash52(std::uint32_t p) {
  p ^= p >> 15;
  p -= p << 17;
  p += p << 7;
  p += p << 4;
  p ^= p >> 5;
  p += p << 16;
  p ^= p >> 7;
  p ^= p >> 3;
  p ^= p << 6;
  p ^= p >> 17;
  return p;
}

// Implements section 23.21, "Partition pattern generation", for a two-dimensional block with few texels.
unsigned subset_of(unsigned seed, unsigned x, unsigned y, unsigned subsets) {
  x *= 2;
  y *= 2;
  seed += (subsets - 1) * 1024;
  const std::uint32_t random = hash52(seed);
  const unsigned by_count = subsets == 3 ? 6 : 5, by_seed = (seed & 2) != 0 ? 4 : 5;
  const unsigned odd = (seed & 1) != 0 ? by_seed : by_count, even = (seed & 1) != 0 ? by_count : by_seed;
  const auto factor = [&](unsigned shift, unsigned down) {
    const std::uint32_t four = random >> shift & 15;
    return four * four >> down;
  };
  const std::uint32_t a = (factor(0, odd) * x + factor(4, even) * y + (random >> 14)) & 63;
  const std::uint32_t b = (factor(8, odd) * x + factor(12, even) * y + (random >> 10)) & 63;
  const std::uint32_t c = subsets < 3 ? 0 : (factor(16, odd) * x + factor(20, even) * y + (random >> 6)) & 63;
  if (a >= b && a >= c) return 0;
  return b >= c ? 1 : 2;
}

// Implements section 23.13, "Color endpoint unquantization". The letters in `pattern` are bits of the value, from the
// highest of 9 bits.
unsigned unquantized(unsigned value, const UastcMode& mode) {
  struct Rule {
    unsigned base, bits;
    const char* pattern;
    unsigned factor;
  };
  constexpr Rule kRules[] = {{3, 2, "b000b0bb0", 93},
                             {5, 3, "cb0000cbc", 26},
                             {3, 4, "dcb000dcb", 22},
                             {5, 5, "edcb0000e", 6},
                             {3, 6, "fedcb000f", 5}};
  const unsigned bits = value & ((1u << mode.endpoint_bits) - 1);
  for (const Rule& rule : kRules) {
    if (rule.base != mode.endpoint_base || rule.bits != mode.endpoint_bits) continue;
    unsigned spread = 0;
    for (const char* c = rule.pattern; *c != '\0'; ++c)
      spread = spread << 1 | (*c == '0' ? 0u : bits >> static_cast<unsigned>(*c - 'a') & 1);
    const unsigned all = (bits & 1) != 0 ? 511 : 0;
    const unsigned mixed = ((value >> mode.endpoint_bits) * rule.factor + spread) ^ all;
    return (all & 0x80) | mixed >> 2;
  }
  unsigned repeated = bits << (8 - mode.endpoint_bits);
  for (unsigned filled = mode.endpoint_bits; filled < 8; filled *= 2) repeated |= repeated >> filled;
  return repeated;
}

// Maps a weight with this number of bits to 0..64 (23.18).
unsigned unquantized_weight(unsigned weight, unsigned bits) {
  unsigned six = weight << (6 - bits);
  for (unsigned filled = bits; filled < 6; filled *= 2) six |= six >> filled;
  return six > 32 ? six + 1 : six;
}

using Endpoints = std::array<unsigned, 18>;

Endpoints read_endpoints(BitReader& bits, const UastcMode& mode) {
  Endpoints values{};
  const unsigned count = mode.components * 2 * mode.subsets;
  const unsigned together = mode.endpoint_base == 3 ? 5 : 3;
  // The numbers of bits that store 0 to 5 trits, or 0 to 3 quints.
  constexpr std::array<unsigned, 6> kTritBits = {0, 2, 4, 5, 7, 8}, kQuintBits = {0, 3, 5, 7, 0, 0};
  for (unsigned first = 0; mode.endpoint_base > 1 && first < count; first += together) {
    const unsigned here = std::min(together, count - first);
    unsigned number = bits.take((mode.endpoint_base == 3 ? kTritBits : kQuintBits)[here]);
    for (unsigned i = first; i < first + here; ++i, number /= mode.endpoint_base)
      values[i] = number % mode.endpoint_base << mode.endpoint_bits;
  }
  for (unsigned i = 0; i < count; ++i) values[i] |= bits.take(mode.endpoint_bits);
  for (unsigned i = 0; i < count; ++i) values[i] = unquantized(values[i], mode);
  return values;
}

unsigned mixed(unsigned low, unsigned high, unsigned weight) {
  return (low * 257 * (64 - weight) + high * 257 * weight + 32) / 64 >> 8;
}

}  // namespace

bool decode_uastc_block(const std::uint8_t* block, std::uint8_t* rgba) {
  const auto found = std::find_if(kUastcModes.begin(), kUastcModes.end(), [&](const UastcMode& one) {
    return (block[0] & ((1u << one.code_bits) - 1)) == one.code;
  });
  if (found == kUastcModes.end()) return false;
  const UastcMode& mode = *found;
  const auto number = static_cast<unsigned>(found - kUastcModes.begin());
  BitReader bits(block);
  bits.skip(mode.code_bits + mode.hint_bits);
  if (number == kSolidMode) {
    for (std::size_t c = 0; c < 4; ++c) {
      const auto value = static_cast<std::uint8_t>(bits.take(8));
      for (std::size_t i = 0; i < kTexels; ++i) rgba[4 * i + c] = value;
    }
    return true;
  }
  unsigned seed = 0;
  if (mode.subsets > 1) {
    const unsigned pattern = bits.take(mode.subsets == 2 ? 5 : 4);
    const std::size_t count = mode.subsets == 3 ? kSeedsOfThree.size()
                              : number == 7     ? kSeedsOfMode7.size()
                                                : kSeedsOfTwo.size();
    if (pattern >= count) return false;
    seed = mode.subsets == 3 ? kSeedsOfThree[pattern] : number == 7 ? kSeedsOfMode7[pattern] : kSeedsOfTwo[pattern];
  }
  constexpr unsigned kNoChannel = 4, kAlpha = 3;
  unsigned second_plane = kNoChannel;  // the channel with separate weights
  if (mode.planes == 2) second_plane = mode.components == 2 ? kAlpha : bits.take(2);
  const Endpoints endpoints = read_endpoints(bits, mode);
  std::array<bool, 3> is_begun{};
  for (unsigned i = 0; i < kTexels; ++i) {
    const unsigned subset = mode.subsets > 1 ? subset_of(seed, i % 4, i / 4, mode.subsets) : 0;
    std::array<unsigned, 2> weights{};
    for (unsigned plane = 0; plane < mode.planes; ++plane)
      weights[plane] = unquantized_weight(bits.take(mode.weight_bits - (is_begun[subset] ? 0 : 1)), mode.weight_bits);
    is_begun[subset] = true;
    for (unsigned c = 0; c < 4; ++c) {
      // If there are two components, the first is grey and the second is alpha.
      const unsigned component = mode.components == 2 ? (c == kAlpha ? 1 : 0) : c;
      const std::size_t at = (subset * mode.components + component) * 2;
      rgba[4 * i + c] =
          component >= mode.components
              ? std::uint8_t{255}
              : static_cast<std::uint8_t>(mixed(endpoints[at], endpoints[at + 1], weights[c == second_plane]));
    }
  }
  return true;
}

}  // namespace multum
