// SPDX-License-Identifier: Apache-2.0
// Reads the index of a packed field, NAME.mpt. The index lists the sections and their positions, so that a reader can
// fetch one block by its byte range.
//
//      "MPTF"      4 bytes
//      version     1 byte: 2
//      length      4 bytes: length of the index that follows, without its checksum
//      index       number of sections; of each: kind, layer, block, length (numbers of ByteReader), checksum (4 bytes)
//      checksum    4 bytes: section_checksum of all bytes before it
//      sections    back to back, in the index's order
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/fields/codec/decoder/byte_reader.h"

namespace multum {

enum class SectionKind : std::uint32_t {
  kDescription = 0,  // description of the field
  kChunk = 1,        // textures of a layer over a block
};

struct PackedSection {
  std::uint32_t kind = 0;  // a SectionKind, or a kind of a later version, which is skipped
  std::uint32_t layer = 0, block = 0;
  std::uint64_t offset = 0, length = 0;  // position in the file, bytes
  std::uint32_t checksum = 0;
};

class PackedIndex {
 public:
  static constexpr std::uint8_t kVersion = 2;  // version 1 had no groups of blocks and was never released
  static constexpr std::size_t kHeadBytes = 9;
  static constexpr std::size_t kIndexBytesMax = std::size_t{1} << 26;
  static constexpr std::uint64_t kSectionBytesMax = std::uint64_t{1} << 32;

  /// Returns how many bytes from the file's beginning `read` needs, computed from the first kHeadBytes. If the format
  /// or version is not supported, returns nullopt and sets `problem` to the format or version found.
  static std::optional<std::size_t> bytes_needed(std::span<const std::uint8_t> head, std::string& problem);

  /// Reads the index from at least bytes_needed() bytes. Returns nullopt if they are damaged, and sets `problem`.
  static std::optional<PackedIndex> read(std::span<const std::uint8_t> begin, std::string& problem);

  const std::vector<PackedSection>& sections() const { return sections_; }
  /// Returns the first matching section, or null.
  const PackedSection* find(SectionKind kind, std::uint32_t layer, std::uint32_t block) const;
  /// Returns the size of the whole file in bytes.
  std::uint64_t file_bytes() const { return file_bytes_; }

 private:
  std::vector<PackedSection> sections_;
  std::uint64_t file_bytes_ = 0;
};

/// Returns whether `bytes` are the section's undamaged bytes.
bool is_intact(const PackedSection& section, std::span<const std::uint8_t> bytes);

}  // namespace multum
