// SPDX-License-Identifier: Apache-2.0
// Defines two ports of a SymbolCoder for the encoder. One port writes bytes. The other port only counts the cost of
// symbols and does not change the contexts.
#pragma once

#include <cmath>

#include "host/fields/codec/decoder/symbol_coder.h"
#include "host/fields/codec/range_encoder.h"

namespace multum {

class EncodingPort {
 public:
  static constexpr bool kLearns = true, kDecodes = false;
  bool code(bool bit, std::uint32_t probability) {
    encoder_.encode(bit, probability);
    return bit;
  }
  std::size_t bits() const { return encoder_.bits(); }
  std::vector<std::uint8_t> finish() { return encoder_.finish(); }

 private:
  RangeEncoder encoder_;
};

class CountingPort {
 public:
  static constexpr bool kLearns = false, kDecodes = false;
  bool code(bool bit, std::uint32_t probability) {
    bits_ += costs()[(bit ? probability : 65536 - probability) / 64];
    return bit;
  }
  float bits() const { return bits_; }

 private:
  /// Returns the bits of a symbol with probability (i + 1/2) / 1024.
  static const std::array<float, 1025>& costs() {
    static const auto table = [] {
      std::array<float, 1025> values{};
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = -std::log2(std::min(1.0f, (static_cast<float>(i) + 0.5f) / 1024.0f));
      return values;
    }();
    return table;
  }

  float bits_ = 0.0f;
};

}  // namespace multum
