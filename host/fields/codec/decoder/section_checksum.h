// SPDX-License-Identifier: Apache-2.0
// Computes the checksum of a packed file's sections. This is the lower 32 bits of CRC-64/XZ, as in
// host/foundation/base/files, but without that folder's libraries.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace multum {

inline std::uint64_t crc64_xz(std::span<const std::uint8_t> bytes) {
  static constexpr auto kTable = [] {
    std::array<std::uint64_t, 256> table{};
    for (std::uint64_t i = 0; i < 256; ++i) {
      std::uint64_t value = i;
      for (int bit = 0; bit < 8; ++bit) value = value >> 1 ^ (value & 1 ? 0xc96c5795d7870f42u : 0u);
      table[i] = value;
    }
    return table;
  }();
  std::uint64_t value = ~std::uint64_t{0};
  for (const std::uint8_t byte : bytes) value = value >> 8 ^ kTable[(value ^ byte) & 255];
  return ~value;
}

inline std::uint32_t section_checksum(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(crc64_xz(bytes));
}

}  // namespace multum
