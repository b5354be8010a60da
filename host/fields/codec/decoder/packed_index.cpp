// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/packed_index.h"

#include <algorithm>
#include <array>

#include "host/fields/codec/decoder/section_checksum.h"

namespace multum {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic = {'M', 'P', 'T', 'F'};
constexpr std::size_t kChecksumBytes = 4;
constexpr std::size_t kSectionBytesLeast = 4 + kChecksumBytes;  // least number of index bytes per section

}  // namespace

std::optional<std::size_t> PackedIndex::bytes_needed(std::span<const std::uint8_t> head, std::string& problem) {
  ByteReader reader(head);
  const auto magic = reader.bytes(kMagic.size());
  if (reader.failed() || !std::equal(magic.begin(), magic.end(), kMagic.begin())) {
    problem = "not a packed field: it does not begin with MPTF";
    return {};
  }
  const std::uint8_t version = reader.byte();
  const std::uint64_t length = reader.fixed(4);
  if (reader.failed()) {
    problem = "cut short within its first 9 bytes";
    return {};
  }
  if (version != PackedIndex::kVersion) {
    problem =
        "a packed field of version " + std::to_string(version) + ", expected " + std::to_string(PackedIndex::kVersion);
    return {};
  }
  if (length > kIndexBytesMax) {
    problem = "a packed field with an index of " + std::to_string(length) + " bytes, expected at most 2^26";
    return {};
  }
  return kHeadBytes + static_cast<std::size_t>(length) + kChecksumBytes;
}

std::optional<PackedIndex> PackedIndex::read(std::span<const std::uint8_t> begin, std::string& problem) {
  const auto needed = bytes_needed(begin.first(std::min(begin.size(), kHeadBytes)), problem);
  if (!needed) return {};
  const auto refuse = [&problem](const char* what) {
    problem = what;
    return std::nullopt;
  };
  if (begin.size() < *needed) return refuse("cut short within its index");
  const auto checked = begin.first(*needed - kChecksumBytes);
  ByteReader checksum(begin.subspan(checked.size(), kChecksumBytes));
  if (checksum.fixed(4) != section_checksum(checked)) return refuse("the checksum of its index differs");

  constexpr std::uint64_t kNumberMax = 0xffffffffu;
  ByteReader reader(checked.subspan(kHeadBytes));
  PackedIndex index;
  index.file_bytes_ = *needed;
  const std::uint64_t count = reader.number(kIndexBytesMax);
  if (count > reader.left() / kSectionBytesLeast) return refuse("its index contains fewer sections than it states");
  for (std::uint64_t i = 0; i < count; ++i) {
    PackedSection section;
    section.kind = static_cast<std::uint32_t>(reader.number(kNumberMax));
    section.layer = static_cast<std::uint32_t>(reader.number(kNumberMax));
    section.block = static_cast<std::uint32_t>(reader.number(kNumberMax));
    section.length = reader.number(kSectionBytesMax);
    section.checksum = static_cast<std::uint32_t>(reader.fixed(4));
    section.offset = index.file_bytes_;
    index.file_bytes_ += section.length;
    index.sections_.push_back(section);
  }
  if (reader.failed() || reader.left() > 0) return refuse("its index is longer or shorter than its sections");
  return index;
}

const PackedSection* PackedIndex::find(SectionKind kind, std::uint32_t layer, std::uint32_t block) const {
  const auto found = std::find_if(sections_.begin(), sections_.end(), [&](const PackedSection& section) {
    return section.kind == static_cast<std::uint32_t>(kind) && section.layer == layer && section.block == block;
  });
  return found == sections_.end() ? nullptr : &*found;
}

bool is_intact(const PackedSection& section, std::span<const std::uint8_t> bytes) {
  return bytes.size() == section.length && section_checksum(bytes) == section.checksum;
}

}  // namespace multum
