// SPDX-License-Identifier: Apache-2.0
// Computes CRC-64 for this program's scratch files, which can be truncated or damaged. CRC-64 takes one hundredth of
// the time of SHA-256, and scratch files need no protection against forgery.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace multum {

class Checksum {
 public:
  void update(const void* data, std::size_t byte_count);
  /// Returns 16 lower-case hexadecimal digits.
  std::string text() const;

 private:
  std::uint64_t value_ = 0;
};

}  // namespace multum
