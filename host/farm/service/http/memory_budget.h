// SPDX-License-Identifier: Apache-2.0
// Defines a budget of bytes that many users share. If a request asks for more bytes than are left, it fails.
// Destructors return the bytes.
#pragma once

#include <cstddef>
#include <utility>

namespace multum {

/// Only one thread may use a budget.
class MemoryBudget {
 public:
  explicit MemoryBudget(std::size_t bytes_max) : bytes_max_(bytes_max) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  std::size_t used() const { return used_; }

 private:
  friend class MemoryShare;
  const std::size_t bytes_max_;
  std::size_t used_ = 0;
};

/// A part of a budget. Its destructor returns the part to the budget.
class MemoryShare {
 public:
  explicit MemoryShare(MemoryBudget& budget) : budget_(&budget) {}
  MemoryShare(MemoryShare&& other) noexcept : budget_(other.budget_), bytes_(std::exchange(other.bytes_, 0)) {}
  MemoryShare& operator=(MemoryShare&&) = delete;
  ~MemoryShare() { budget_->used_ -= bytes_; }

  std::size_t bytes() const { return bytes_; }
  /// Changes the part to `bytes`. If the budget has too few bytes left, changes nothing and returns false.
  bool resize(std::size_t bytes) {
    if (bytes > bytes_ && bytes - bytes_ > budget_->bytes_max_ - budget_->used_) return false;
    budget_->used_ += bytes - bytes_;
    bytes_ = bytes;
    return true;
  }

 private:
  MemoryBudget* budget_;
  std::size_t bytes_ = 0;
};

}  // namespace multum
