// SPDX-License-Identifier: Apache-2.0
// Tests the range coder and its contexts. Decoding returns the encoded symbols, and streams have about the length that
// the probabilities predict. A stream that is cut off gives the symbols that are certain and then zeros. Random bytes
// do no harm.
#include <gtest/gtest.h>

#include <algorithm>

#include "host/fields/codec/coding_ports.h"
#include "tests/unit/fields/codec/codec_test_data.h"

namespace multum {
namespace {

struct Symbol {
  bool bit;
  std::uint32_t probability;
};

enum class Kind { kLikely, kUnlikely, kExtreme, kEven };

std::vector<Symbol> symbols_of(Kind kind, std::size_t count, SplitMix64& random) {
  std::vector<Symbol> symbols(count);
  for (Symbol& symbol : symbols) {
    symbol.probability = static_cast<std::uint32_t>(1 + random.next() % 65535);
    if (kind == Kind::kExtreme) symbol.probability = random.next() % 2 == 0 ? 1 : 65535;
    if (kind == Kind::kEven) symbol.probability = 32768;
    const bool likely = random.next() % 65536 < symbol.probability;
    symbol.bit = kind == Kind::kUnlikely ? !likely : likely;
  }
  return symbols;
}

std::vector<std::uint8_t> encoded(const std::vector<Symbol>& symbols) {
  RangeEncoder encoder;
  for (const Symbol& symbol : symbols) encoder.encode(symbol.bit, symbol.probability);
  return encoder.finish();
}

TEST(RangeCoder, EverySymbolComesBack) {
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    for (const Kind kind : {Kind::kLikely, Kind::kUnlikely, Kind::kExtreme, Kind::kEven}) {
      SCOPED_TRACE(seed);
      SplitMix64 random(seed);
      const auto symbols = symbols_of(kind, random.next() % 400, random);
      const auto bytes = encoded(symbols);
      RangeDecoder decoder(bytes);
      double bits = 0.0;
      for (const Symbol& symbol : symbols) {
        ASSERT_EQ(decoder.decode(symbol.probability), symbol.bit);
        bits -= std::log2((symbol.bit ? symbol.probability : 65536.0 - symbol.probability) / 65536.0);
      }
      EXPECT_FALSE(decoder.exhausted());
      // Rounding the interval costs less than 1/256 of the interval per symbol, and ending the stream costs at most two
      // bytes.
      EXPECT_LE(8.0 * static_cast<double>(bytes.size()), bits + 0.006 * static_cast<double>(symbols.size()) + 16.0);
    }
}

TEST(RangeCoder, CarriesRunThroughLongRowsOfOnes) {
  // These symbols keep the number 1/2 inside the interval and the interval's lower end below 1/2, so the written bytes
  // are 7f ff ff ff ... Then one symbol moves the lower end above 1/2, and all of these bytes change.
  SplitMix64 random(9);
  std::vector<Symbol> symbols;
  std::uint64_t range = 0xffffffff, distance = std::uint64_t{1} << 31;  // from the interval's lower end to 1/2
  const auto probability = [&] { return static_cast<std::uint32_t>(1 + random.next() % 65535); };
  while (symbols.size() < 3000) {
    const Symbol symbol{false, probability()};
    const std::uint64_t bound = (range >> 16) * symbol.probability;
    if (bound == distance) continue;
    symbols.push_back({distance < bound, symbol.probability});
    distance -= distance < bound ? 0 : bound;
    range = symbols.back().bit ? bound : range - bound;
    for (; range < (1u << 24); range <<= 8) distance <<= 8;
  }
  symbols.push_back({false, static_cast<std::uint32_t>(distance / (range >> 16) + 1)});
  const auto bytes = encoded(symbols);
  EXPECT_EQ(bytes[0], 128);
  EXPECT_GT(std::count(bytes.begin() + 1, bytes.end(), 0), 250);
  RangeDecoder decoder(bytes);
  for (const Symbol& symbol : symbols) ASSERT_EQ(decoder.decode(symbol.probability), symbol.bit);
}

TEST(RangeCoder, AnyPrefixGivesCertainSymbolsThenZeros) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    SplitMix64 random(seed);
    const auto symbols = symbols_of(Kind::kLikely, 300, random);
    const auto bytes = encoded(symbols);
    std::size_t known_before = 0;
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
      RangeDecoder decoder(std::span<const std::uint8_t>(bytes).first(cut));
      std::size_t known = 0;
      for (const Symbol& symbol : symbols) {
        const bool bit = decoder.decode(symbol.probability);
        if (decoder.exhausted()) {
          ASSERT_FALSE(bit);
          continue;
        }
        ASSERT_EQ(bit, symbol.bit);
        ++known;
      }
      EXPECT_GE(known, known_before);
      known_before = known;
    }
    EXPECT_EQ(known_before, symbols.size());
  }
}

TEST(RangeCoder, BytesOfStrangersDecodeToSomething) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SplitMix64 random(seed);
    auto bytes = random_bytes(random, random.next() % 40);
    if (seed % 3 == 0) std::fill(bytes.begin(), bytes.end(), std::uint8_t{255});
    RangeDecoder decoder(bytes);
    for (int i = 0; i < 1000; ++i) decoder.decode(static_cast<std::uint32_t>(1 + random.next() % 65535));
  }
}

TEST(RangeCoder, AnEmptyStreamTakesNoBytesOfSymbolsAndSaysThatItEnded) {
  RangeDecoder decoder({});
  EXPECT_FALSE(decoder.exhausted());
  EXPECT_FALSE(decoder.decode(32768));
  EXPECT_TRUE(decoder.exhausted());
}

TEST(AdaptiveBit, LearnsAProbabilityAndFollowsAChange) {
  SplitMix64 random(5);
  AdaptiveBit bit;
  for (int i = 0; i < 3000; ++i) bit.update(random.next() % 10 == 0);
  EXPECT_NEAR(bit.probability(), 6554, 4000);
  for (int i = 0; i < 3000; ++i) bit.update(true);
  EXPECT_GT(bit.probability(), 64000u);
  EXPECT_LT(bit.probability(), 65536u);
  for (int i = 0; i < 3000; ++i) bit.update(false);
  EXPECT_LT(bit.probability(), 1000u);
  EXPECT_GT(bit.probability(), 0u);
}

TEST(BitMixer, LogOddsRiseWithTheProbabilityAndComeBack) {
  int before = -3000;
  for (std::uint32_t p = 0; p <= 65535; p += 5) {
    const int odds = log_odds(p);
    ASSERT_GE(odds, before);
    before = odds;
    if (p >= 64 && p <= 65472) {
      EXPECT_NEAR(probability_of(odds), p, 0.02 * std::min(p, 65536 - p) + 24) << p;
    }
  }
  EXPECT_GT(probability_of(-100000), 0u);
  EXPECT_LT(probability_of(100000), 65536u);
}

TEST(BitMixer, FollowsTheContextThatKnows) {
  SplitMix64 random(7);
  BitMixer mixer;
  double bits = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const bool bit = random.next() % 2 == 0;
    const std::array<int, 2> inputs = {bit ? 500 : -500,
                                       // One of them predicts well, and the other one guesses.
                                       random.next() % 2 == 0 ? 500 : -500};
    const std::uint32_t p = mixer.mix(inputs);
    if (i >= 2000) bits -= std::log2((bit ? p : 65536 - p) / 65536.0);
    mixer.update(inputs, p, bit);
  }
  EXPECT_LT(bits / 2000.0, 0.1);  // without mixing, the good predictor needs log2(1 + exp(-500 / 256)) = 0.19 bits
}

TEST(SymbolCoder, NumbersComeBack) {
  const std::vector<std::uint32_t> numbers = {0, 1, 2, 3, 7, 8, 100, 255, 256, 65534, 0, 12345};
  EncodingPort port;
  SymbolCoder<EncodingPort> coder(port);
  std::array<AdaptiveBit, 17> contexts;
  for (const auto number : numbers) EXPECT_EQ(coder.number(number, contexts), number);
  const auto bytes = port.finish();
  DecodingPort decoding(bytes);
  SymbolCoder<DecodingPort> decoder(decoding);
  std::array<AdaptiveBit, 17> decoder_contexts;
  for (const auto number : numbers) EXPECT_EQ(decoder.number(0, decoder_contexts), number);
}

}  // namespace
}  // namespace multum
