// SPDX-License-Identifier: Apache-2.0
// Reads the index of a packed field, NAME.mpt: which sections there are, and where, so that one block can be fetched by
// its range of bytes.
//
//      "MPTF"      4 bytes
//      version     1 byte: 2
//      length      4 bytes, of the index that follows, without its checksum
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
  kDescription = 0,  // of the field
  kChunk = 1,        // textures: of a layer over a block
};

struct PackedSection {
  std::uint32_t kind = 0;  // a SectionKind, or one of later versions, to be passed over
  std::uint32_t layer = 0, block = 0;
  std::uint64_t offset = 0, length = 0;  // in the file, bytes
  std::uint32_t checksum = 0;
};

class PackedIndex {
 public:
  static constexpr std::uint8_t kVersion = 2;  // 1 had no groups of blocks and was not released
  static constexpr std::size_t kHeadBytes = 9;
  static constexpr std::size_t kIndexBytesMax = std::size_t{1} << 26;
  static constexpr std::uint64_t kSectionBytesMax = std::uint64_t{1} << 32;

  /// How many bytes of the file's begin `read` needs, from the first kHeadBytes. Nothing for another format or version;
  /// `problem` then says what was found.
  static std::optional<std::size_t> bytes_needed(std::span<const std::uint8_t> head, std::string& problem);

  /// From at least so many bytes of the file's begin. Nothing where they are damaged: `problem` then says how.
  static std::optional<PackedIndex> read(std::span<const std::uint8_t> begin, std::string& problem);

  const std::vector<PackedSection>& sections() const { return sections_; }
  /// Null when there is none; the first, should there be several.
  const PackedSection* find(SectionKind kind, std::uint32_t layer, std::uint32_t block) const;
  /// Bytes that the whole file has.
  std::uint64_t file_bytes() const { return file_bytes_; }

 private:
  std::vector<PackedSection> sections_;
  std::uint64_t file_bytes_ = 0;
};

/// Whether `bytes` are the section's, undamaged.
bool is_intact(const PackedSection& section, std::span<const std::uint8_t> bytes);

}  // namespace multum
