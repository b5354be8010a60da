// SPDX-License-Identifier: Apache-2.0
// Generates random numbers that are the same on every machine and standard library: SplitMix64 (Steele, Lea and Flood
// 2014, "Fast splittable pseudorandom number generators").
#pragma once

#include <cstdint>

namespace multum {

/// Computes number `counter` of the sequence directly, so threads do not depend on one another.
inline std::uint64_t split_mix(std::uint64_t counter) {
  std::uint64_t z = counter + 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

class SplitMix64 {
 public:
  /// Starts the sequence of `seed` after its first `skipped_count` numbers.
  explicit SplitMix64(std::uint64_t seed, std::uint64_t skipped_count = 0) : state_(seed + skipped_count * kStep) {}
  std::uint64_t next() {
    const std::uint64_t number = split_mix(state_);
    state_ += kStep;
    return number;
  }
  /// Returns a number in (0, 1]. Its logarithm is therefore finite.
  double uniform() { return (static_cast<double>(next() >> 11) + 1.0) * 0x1.0p-53; }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15u;
  std::uint64_t state_;
};

}  // namespace multum
