// SPDX-License-Identifier: Apache-2.0
// Codes binary symbols with their contexts. The formats of this folder are built on this coder. Each format is one
// function template over a coder, so that encoder, decoder and size estimates cannot differ. Each call takes the symbol
// to write and returns the actual symbol. A decoder ignores its argument.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>

#include "host/fields/codec/decoder/adaptive_bit.h"
#include "host/fields/codec/decoder/bit_mixer.h"
#include "host/fields/codec/decoder/range_decoder.h"

namespace multum {

/// Passes symbols with their probabilities to the function `bool Port::code(bool, probability)`. If Port::kDecodes is
/// set, the symbols to write are ignored.
template <class Port>
class SymbolCoder {
 public:
  explicit SymbolCoder(Port& port) : port_(port) {}

  bool bit(bool value, AdaptiveBit& context) {
    const bool coded = port_.code(value, context.probability());
    if constexpr (Port::kLearns) context.update(coded);
    return coded;
  }

  /// Codes a bit with two to four contexts. Several calls can share `mixer`.
  bool bit(bool value, std::initializer_list<AdaptiveBit*> contexts, BitMixer& mixer) {
    std::array<int, BitMixer::kInputsMax> odds{};
    std::size_t n = 0;
    for (const AdaptiveBit* context : contexts) odds[n++] = log_odds(context->probability());
    const std::span<const int> inputs(odds.data(), n);
    const std::uint32_t probability = mixer.mix(inputs);
    const bool coded = port_.code(value, probability);
    if constexpr (Port::kLearns) {
      mixer.update(inputs, probability, coded);
      for (AdaptiveBit* context : contexts) context->update(coded);
    }
    return coded;
  }

  /// Codes a bit with equal probabilities.
  bool even_bit(bool value) { return port_.code(value, 32768); }

  /// Codes an integer from 0 to 2^16 - 1. Writes its bit length in unary with `contexts`, then all bits after the first
  /// one.
  std::uint32_t number(std::uint32_t value, std::span<AdaptiveBit, 17> contexts) {
    std::uint32_t length = 0, above = value + 1;  // 1 to 2^16
    while (above >> length > 1) ++length;
    std::uint32_t coded_length = 0;
    while (coded_length < 16 && bit(coded_length < length, contexts[coded_length])) ++coded_length;
    std::uint32_t coded = 1;
    for (std::uint32_t i = coded_length; i-- > 0;) coded = coded << 1 | (even_bit(above >> i & 1) ? 1u : 0u);
    return coded - 1;
  }

 private:
  Port& port_;
};

/// Reads symbols from bytes.
class DecodingPort {
 public:
  static constexpr bool kLearns = true, kDecodes = true;
  explicit DecodingPort(std::span<const std::uint8_t> bytes) : decoder_(bytes) {}
  bool code(bool, std::uint32_t probability) { return decoder_.decode(probability); }
  bool exhausted() const { return decoder_.exhausted(); }

 private:
  RangeDecoder decoder_;
};

}  // namespace multum
