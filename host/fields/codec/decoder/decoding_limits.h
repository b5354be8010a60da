// SPDX-License-Identifier: Apache-2.0
// Limits the memory and time for decoding a chunk. Without limits, a few untrusted bytes could require gigabytes of
// coefficients and minutes of time.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace multum {

struct DecodingLimits {
  /// The most bytes that coefficients may take, including those needed only while decoding. A chunk that needs more is
  /// refused.
  std::size_t bytes_max = SIZE_MAX;
  /// The flag is checked in every block. If it is true, decoding ends at once. If the pointer is null, decoding cannot
  /// be cancelled.
  const std::atomic<bool>* cancelled = nullptr;
  /// The decoder sets this flag to true if bytes_max was too small. The pointer may be null.
  bool* ran_out = nullptr;
};

/// Tracks how much of its limits a decoding has used.
class DecodingAccount {
 public:
  explicit DecodingAccount(const DecodingLimits& limits) : limits_(limits) {}

  /// Sets the number of bytes that decoded images take.
  void set_kept(std::size_t bytes) { kept_ = bytes; }
  /// Returns whether the current image's bytes exceed the limit, or the decoding is cancelled. Once true, the result
  /// stays true.
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
