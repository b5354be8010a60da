// SPDX-License-Identifier: Apache-2.0
// Reads numbers from untrusted bytes. The numbers are little-endian, or have a variable length with seven bits per
// byte, starting with the lowest bits. After the end of the bytes, or after the first invalid number, all reads return
// 0 and `failed` is true.
#pragma once

#include <cstdint>
#include <span>

namespace multum {

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t byte() {
    if (next_ >= bytes_.size()) failed_ = true;
    return failed_ ? std::uint8_t{0} : bytes_[next_++];
  }

  /// Returns an unsigned number of `count` bytes, at most 8.
  std::uint64_t fixed(int count) {
    std::uint64_t value = 0;
    for (int i = 0; i < count; ++i) value |= std::uint64_t{byte()} << (8 * i);
    return failed_ ? 0 : value;
  }

  std::int16_t int16() { return static_cast<std::int16_t>(fixed(2)); }

  /// Returns a number that is at most `most` and stored in up to nine bytes.
  std::uint64_t number(std::uint64_t most) {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 63; shift += 7) {
      const std::uint8_t next = byte();
      value |= std::uint64_t{next & 127u} << shift;
      if (next < 128) {
        if (value > most) failed_ = true;
        return failed_ ? 0 : value;
      }
    }
    failed_ = true;
    return 0;
  }

  std::span<const std::uint8_t> bytes(std::size_t count) {
    if (failed_ || count > bytes_.size() - next_) {
      failed_ = true;
      return {};
    }
    next_ += count;
    return bytes_.subspan(next_ - count, count);
  }

  std::size_t position() const { return next_; }
  std::size_t left() const { return failed_ ? 0 : bytes_.size() - next_; }
  bool failed() const { return failed_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
  bool failed_ = false;
};

}  // namespace multum
