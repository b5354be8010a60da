// SPDX-License-Identifier: Apache-2.0
// Holds quantized coefficients of an image's blocks in three planes. Most blocks contain only zeros. Such blocks take
// no memory.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace multum {

class CoefficientBlocks {
 public:
  static constexpr std::size_t kPlanes = 3;
  static constexpr int kMagnitudeMax = 32767;

  CoefficientBlocks() = default;
  CoefficientBlocks(std::size_t block_count, std::size_t block_values)
      : block_count_(block_count), block_values_(block_values) {}

  /// Returns the values of a block, or an empty span if all values are zero.
  std::span<const std::int16_t> block(std::size_t plane, std::size_t number) const {
    if (begins_[plane].empty() || begins_[plane][number] < 0) return {};
    const auto begin = begins_[plane][number];
    return {values_.data() + begin, block_values_};
  }

  /// Returns the values of a block for writing. New values are zero. The span is valid until the next call.
  std::span<std::int16_t> make(std::size_t plane, std::size_t number) {
    if (begins_[plane].empty()) begins_[plane].assign(block_count_, -1);
    auto& begin = begins_[plane][number];
    if (begin < 0) {
      begin = static_cast<std::int32_t>(values_.size());  // no overflow: an image has at most 2^28 texels and three
                                                          // planes
      values_.resize(values_.size() + block_values_);
    }
    return {values_.data() + begin, block_values_};
  }

  bool is_empty() const { return values_.empty(); }
  bool has_plane(std::size_t plane) const { return !begins_[plane].empty(); }
  std::size_t block_count() const { return block_count_; }

  /// Returns the number of bytes in memory, including reserved memory.
  std::size_t memory_bytes() const {
    std::size_t bytes = values_.capacity() * sizeof(std::int16_t);
    for (const auto& begins : begins_) bytes += begins.capacity() * sizeof(std::int32_t);
    return bytes;
  }
  /// Frees reserved memory that no value uses.
  void shrink() { values_.shrink_to_fit(); }

 private:
  std::size_t block_count_ = 0, block_values_ = 0;
  std::array<std::vector<std::int32_t>, kPlanes> begins_;
  std::vector<std::int16_t> values_;
};

}  // namespace multum
