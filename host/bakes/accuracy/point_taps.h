// SPDX-License-Identifier: Apache-2.0
// Stores points of a pyramid. A point consists of any number of weighted texels, which are the texels that a filter
// reads.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace multum {

struct WeightedSlot {
  std::size_t slot;  // slot of a TexelSelection
  double weight;
};

class PointTaps {
 public:
  std::size_t size() const { return ends_.size(); }
  std::span<const WeightedSlot> of(std::size_t point) const {
    const std::size_t begin = point == 0 ? 0 : ends_[point - 1];
    return {taps_.data() + begin, ends_[point] - begin};
  }
  void clear() {
    taps_.clear();
    ends_.clear();
  }
  /// Adds a texel to the current point.
  void add(std::size_t slot, double weight) { taps_.push_back({slot, weight}); }
  void finish_point() { ends_.push_back(taps_.size()); }

 private:
  std::vector<WeightedSlot> taps_;
  std::vector<std::size_t> ends_;  // [point]
};

}  // namespace multum
