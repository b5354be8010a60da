// SPDX-License-Identifier: Apache-2.0
// Counts bytes against a limit. Refuses bytes beyond the limit before they are allocated. Two threads must not use one
// account at once.
#pragma once

#include <algorithm>
#include <cstddef>

#include "host/foundation/base/error.h"

namespace multum {

class MemoryAccount {
 public:
  explicit MemoryAccount(std::size_t bytes_max) : bytes_max_(bytes_max) {}

  bool has_room(std::size_t bytes) const { return bytes <= bytes_max_ - bytes_; }
  /// Counts the bytes, or counts nothing if they do not fit.
  bool take(std::size_t bytes) {
    if (!has_room(bytes)) return false;
    bytes_ += bytes;
    most_ = std::max(most_, bytes_);
    return true;
  }
  void give_back(std::size_t bytes) {
    MULTUM_CHECK(bytes <= bytes_);
    bytes_ -= bytes;
  }

  std::size_t bytes() const { return bytes_; }
  std::size_t most() const { return most_; }  // peak since the beginning
  std::size_t bytes_max() const { return bytes_max_; }

 private:
  std::size_t bytes_max_, bytes_ = 0, most_ = 0;
};

}  // namespace multum
