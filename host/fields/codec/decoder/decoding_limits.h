// SPDX-License-Identifier: Apache-2.0
// Limits what decoding a chunk may take: a few bytes of a stranger's can ask for gigabytes of coefficients and minutes
// of time.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace multum {

struct DecodingLimits {
  /// Of coefficients, those that are needed only while decoding included; a chunk that has more is refused.
  std::size_t bytes_max = SIZE_MAX;
  /// Looked at in every block; true: decoding ends at once. Null: never.
  const std::atomic<bool>* cancelled = nullptr;
  /// Becomes true when bytes_max was too little. Null: nobody asks.
  bool* ran_out = nullptr;
};

/// What one decoding takes of its limits.
class DecodingAccount {
 public:
  explicit DecodingAccount(const DecodingLimits& limits) : limits_(limits) {}

  /// Bytes of images that are decoded.
  void set_kept(std::size_t bytes) { kept_ = bytes; }
  /// Whether so many bytes more of the image at hand are too many, or it is cancelled; from then on always.
  bool is_over(std::size_t image_bytes) {
    has_no_room_ = has_no_room_ || image_bytes > limits_.bytes_max || kept_ > limits_.bytes_max - image_bytes;
    if (has_no_room_ && limits_.ran_out != nullptr) *limits_.ran_out = true;
    return has_no_room_ || is_cancelled();
  }
  bool has_no_room() const { return has_no_room_; }
  bool is_cancelled() const {
    return limits_.cancelled != nullptr && limits_.cancelled->load(std::memory_order_relaxed);
  }

 private:
  DecodingLimits limits_;
  std::size_t kept_ = 0;
  bool has_no_room_ = false;
};

}  // namespace multum
