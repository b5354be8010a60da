// SPDX-License-Identifier: Apache-2.0
// Encodes messages between processes of one machine as bytes. Numbers have the machine's format, and each text follows
// its length. A broken file may have corrupted the other process, so the reader checks every length.
#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace multum {

class MessageWriter {
 public:
  template <typename Number>
  MessageWriter& number(Number value) {
    static_assert(std::is_arithmetic_v<Number> || std::is_enum_v<Number>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
    return *this;
  }
  MessageWriter& text(std::string_view value) {
    number(static_cast<std::uint64_t>(value.size()));
    bytes_.append(value);
    return *this;
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Throws std::out_of_range if the message is shorter than the requested values.
class MessageReader {
 public:
  explicit MessageReader(std::string_view bytes) : bytes_(bytes) {}

  template <typename Number>
  Number number() {
    static_assert(std::is_arithmetic_v<Number> && !std::is_same_v<Number, bool>);
    Number value;
    std::memcpy(&value, take(sizeof(value)).data(), sizeof(value));
    return value;
  }
  std::string text() { return std::string(take(number<std::uint64_t>())); }
  /// Reads a number of items. Each of these items has at least one byte.
  std::size_t count() {
    const auto value = number<std::uint64_t>();
    if (value > bytes_.size()) throw std::out_of_range("a count beyond the end of the message");
    return static_cast<std::size_t>(value);
  }
  bool is_at_end() const { return bytes_.empty(); }
  std::string_view rest() const { return bytes_; }

 private:
  std::string_view take(std::uint64_t count) {
    if (count > bytes_.size()) throw std::out_of_range("a message that is cut");
    const std::string_view taken = bytes_.substr(0, static_cast<std::size_t>(count));
    bytes_.remove_prefix(static_cast<std::size_t>(count));
    return taken;
  }
  std::string_view bytes_;
};

}  // namespace multum
