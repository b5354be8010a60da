// SPDX-License-Identifier: Apache-2.0
// Tests packed files. Sections can be read by their byte ranges, only a damaged section is lost, and hostile bytes do
// no harm.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "host/fields/codec/decoder/section_checksum.h"
#include "host/fields/codec/packed_file.h"
#include "host/foundation/base/files/checksum.h"
#include "tests/unit/fields/codec/codec_test_data.h"

namespace multum {
namespace {

std::vector<SectionSource> test_sections(SplitMix64& random) {
  return {{0, 0, 0, random_bytes(random, 100)},
          {1, 0, 0, random_bytes(random, 3000)},
          {1, 0, 1, random_bytes(random, 0)},
          {1, 7, 300, random_bytes(random, 77)},
          {99, 1, 2, random_bytes(random, 10)}};  // a section that a later version has added
}

TEST(PackedFile, SectionsAreFoundByTheirRanges) {
  SplitMix64 random(1);
  const auto sections = test_sections(random);
  const auto file = packed_file(sections);
  std::string problem;
  const std::span<const std::uint8_t> bytes(file);
  const auto needed = PackedIndex::bytes_needed(bytes.first(PackedIndex::kHeadBytes), problem);
  ASSERT_TRUE(needed) << problem;
  const auto index = PackedIndex::read(bytes.first(*needed), problem);  // opens the file without reading any section
  ASSERT_TRUE(index) << problem;
  EXPECT_EQ(index->file_bytes(), file.size());
  ASSERT_EQ(index->sections().size(), sections.size());
  const PackedSection* chunk = index->find(SectionKind::kChunk, 7, 300);
  ASSERT_NE(chunk, nullptr);
  const auto range = bytes.subspan(chunk->offset, chunk->length);
  EXPECT_TRUE(is_intact(*chunk, range));
  EXPECT_TRUE(std::equal(range.begin(), range.end(), sections[3].bytes.begin(), sections[3].bytes.end()));
  EXPECT_EQ(index->find(SectionKind::kChunk, 7, 301), nullptr);
}

TEST(PackedFile, DamageCostsOneSection) {
  SplitMix64 random(2);
  const auto sections = test_sections(random);
  const auto whole = packed_file(sections);
  std::string problem;
  const auto index = PackedIndex::read(whole, problem);
  ASSERT_TRUE(index);
  const std::size_t sections_begin = index->sections().front().offset;
  for (std::size_t at = 0; at < whole.size(); at += at < sections_begin + 200 ? 1 : 37) {
    auto file = whole;
    file[at] ^= static_cast<std::uint8_t>(1u << at % 8);
    const auto read = PackedIndex::read(file, problem);
    if (at < sections_begin) {
      EXPECT_FALSE(read) << at;
      continue;
    }
    ASSERT_TRUE(read) << problem;
    int broken = 0;
    for (const auto& section : read->sections())
      broken += is_intact(section, std::span<const std::uint8_t>(file).subspan(section.offset, section.length)) ? 0 : 1;
    EXPECT_EQ(broken, 1) << at;
  }
}

TEST(PackedFile, CutAndForeignFilesAreRefused) {
  SplitMix64 random(3);
  const auto whole = packed_file(test_sections(random));
  std::string problem;
  const auto needed = PackedIndex::bytes_needed(whole, problem);
  for (std::size_t cut = 0; cut < *needed; ++cut) {
    problem.clear();
    EXPECT_FALSE(PackedIndex::read(std::span<const std::uint8_t>(whole).first(cut), problem));
    EXPECT_FALSE(problem.empty());
  }
  auto later = whole;
  later[4] = 3;
  EXPECT_FALSE(PackedIndex::read(later, problem));
  EXPECT_EQ(problem, "a packed field of version 3, expected 2");
  for (int round = 0; round < 500; ++round) {
    PackedIndex::read(damaged(whole, random), problem);
    PackedIndex::read(random_bytes(random, random.next() % 100), problem);
  }
}

TEST(PackedFile, IndexesWithARightChecksumAreReadWithCare) {
  // The author of a hostile file can also compute the checksum.
  SplitMix64 random(4);
  const auto whole = packed_file(test_sections(random));
  std::string problem;
  const std::size_t needed = *PackedIndex::bytes_needed(whole, problem);
  int read = 0;
  for (int round = 0; round < 2000; ++round) {
    auto file = whole;
    for (std::uint64_t i = 1 + random.next() % 3; i > 0; --i)
      file[9 + random.next() % (needed - 13)] = static_cast<std::uint8_t>(random.next());
    const std::uint32_t sum = section_checksum(std::span<const std::uint8_t>(file).first(needed - 4));
    for (std::size_t i = 0; i < 4; ++i) file[needed - 4 + i] = static_cast<std::uint8_t>(sum >> (8 * i));
    const auto index = PackedIndex::read(file, problem);
    if (!index) continue;
    ++read;
    std::uint64_t end = needed;
    for (const auto& section : index->sections()) {
      EXPECT_EQ(section.offset, end);
      end += section.length;
    }
    EXPECT_EQ(end, index->file_bytes());
  }
  EXPECT_GT(read, 100);
}

TEST(SectionChecksum, IsTheProjects) {
  SplitMix64 random(5);
  for (const std::size_t count : {0, 1, 9, 1000}) {
    const auto bytes = random_bytes(random, count);
    Checksum checksum;
    checksum.update(bytes.data(), bytes.size());
    EXPECT_EQ(fmt::format("{:016x}", crc64_xz(bytes)), checksum.text());
  }
}

}  // namespace
}  // namespace multum
