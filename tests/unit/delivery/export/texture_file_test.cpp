// SPDX-License-Identifier: Apache-2.0
// Tests the bytes of KTX2 and DDS files. Header fields must be at their specified positions, levels must be in order,
// and Zstandard frames must decompress to the original bytes. tests/cli/exports/export_command_test.cpp reads such
// files with third-party readers.
#include <gtest/gtest.h>

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "host/delivery/export/texture_file.h"
#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/file_limit.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

constexpr TexelFormat kAllFormats[] = {TexelFormat::kR8,  TexelFormat::kRg8, TexelFormat::kRgba8, TexelFormat::kRgba16f,
                                       TexelFormat::kBc4, TexelFormat::kBc5, TexelFormat::kBc7};

std::uint64_t number_at(const std::string& bytes, std::size_t at, std::size_t byte_count) {
  std::uint64_t value = 0;
  for (std::size_t i = byte_count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
  return value;
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Level {
  int columns, rows;  // columns and rows of blocks
};

// Makes the levels of a texture of 7 x 5 texels.
std::vector<Level> levels_of(TexelFormat format) {
  return info_of(format).block_side == 4 ? std::vector<Level>{{2, 2}, {1, 1}, {1, 1}}
                                         : std::vector<Level>{{7, 5}, {3, 2}, {1, 1}};
}

// Every byte of level l is 10 l plus the number of its row.
std::string level_bytes_of(TexelFormat format, std::size_t level) {
  const Level size = levels_of(format)[level];
  std::string bytes;
  for (int row = 0; row < size.rows; ++row)
    bytes.append(static_cast<std::size_t>(size.columns * info_of(format).block_bytes),
                 static_cast<char>(10 * static_cast<int>(level) + row));
  return bytes;
}

// Writes rows of different levels alternately, as an export does.
void write_texture(TextureFile& file, TexelFormat format) {
  const std::vector<Level> levels = levels_of(format);
  for (int row = 0; row < levels[0].rows; ++row)
    for (std::size_t level = 0; level < levels.size(); ++level) {
      if (row >= levels[level].rows) continue;
      const std::string bytes = level_bytes_of(format, level);
      const std::size_t row_bytes = bytes.size() / static_cast<std::size_t>(levels[level].rows);
      file.write_rows(static_cast<int>(level), 1, bytes.data() + static_cast<std::size_t>(row) * row_bytes);
    }
  file.finish();
}

std::string ktx2_bytes(TexelFormat format, const Ktx2Choice& choice) {
  const testing::TemporaryFolder folder;
  const std::string path = folder / "a.ktx2";
  const auto file = make_ktx2_file(path, {format, 7, 5, 3}, choice);
  EXPECT_FALSE(std::filesystem::exists(path)) << "before finish()";
  write_texture(*file, format);
  EXPECT_EQ(folder.names(), testing::Names{"a.ktx2"});
  return bytes_of(path);
}

// With 64 rows of 64 KiB, the file's buffer reaches the disk long before the last row.
TEST(TextureFile, AFailedWriteEndsTheWorkAtOnce) {
  const testing::TemporaryFolder folder;
  const LeveledTexture texture = {TexelFormat::kRgba8, 16384, 64, 1};
  const std::vector<std::uint8_t> row(std::size_t{4} * 16384, 7);
  for (const bool is_dds : {false, true}) {
    const testing::FileLimit limit(256 << 10);
    int written = 0;
    testing::expect_error(ErrorCode::kEnvironment, {"a.tex: writing failed: File too large"}, [&] {
      const auto file =
          is_dds ? make_dds_file(folder / "a.tex", texture) : make_ktx2_file(folder / "a.tex", texture, {});
      for (; written < 64; ++written) file->write_rows(0, 1, row.data());
      file->finish();
    });
    EXPECT_LT(written, 64) << "the failure was noticed only at the end";
  }
  EXPECT_EQ(folder.names(), testing::Names{});
}

// There are two levels of incompressible data. After the frame of the first level fails, the second frame is not
// started.
TEST(TextureFile, AFrameThatCannotBeWrittenEndsTheWorkAtOnce) {
  const testing::TemporaryFolder folder;
  const LeveledTexture texture = {TexelFormat::kRgba8, 2048, 1024, 2};
  std::vector<std::uint32_t> texels(std::size_t{2048} * 1024);
  std::mt19937 random(7);
  std::generate(texels.begin(), texels.end(), random);
  Ktx2Choice choice;
  choice.zstd_level = 1;
  const auto file = make_ktx2_file(folder / "a.ktx2", texture, choice);
  file->write_rows(0, 1024, texels.data());
  file->write_rows(1, 512, texels.data());
  const testing::FileLimit limit(256 << 10);
  testing::expect_error(ErrorCode::kEnvironment, {"a.ktx2: writing failed: File too large"}, [&] { file->finish(); });
}

TEST(TextureFile, Ktx2HasItsHeadAndItsLevels) {
  for (const TexelFormat format : kAllFormats) {
    const TexelFormatInfo& info = info_of(format);
    SCOPED_TRACE(info.name);
    const std::string bytes = ktx2_bytes(format, {});
    EXPECT_EQ(bytes.substr(0, 12), std::string("\xabKTX 20\xbb\r\n\x1a\n"));
    const std::uint64_t type_bytes = format == TexelFormat::kRgba16f ? 2 : 1;
    const std::uint64_t fields[] = {info.vk_format, type_bytes, 7, 5, 0, 0, 1, 3, 0};
    for (std::size_t i = 0; i < std::size(fields); ++i) EXPECT_EQ(number_at(bytes, 12 + 4 * i, 4), fields[i]) << i;
    const std::uint64_t descriptor_at = number_at(bytes, 48, 4), descriptor = number_at(bytes, 52, 4);
    const std::uint64_t keys_at = number_at(bytes, 56, 4), keys = number_at(bytes, 60, 4);
    EXPECT_EQ(descriptor_at, 80u + 3u * 24u);
    EXPECT_EQ(keys_at, descriptor_at + descriptor);
    EXPECT_EQ(number_at(bytes, descriptor_at, 4), descriptor);
    const std::uint64_t samples = format == TexelFormat::kBc7 ? 1 : static_cast<std::uint64_t>(info.channels);
    EXPECT_EQ(descriptor, 28u + 16u * samples);
    // The sample descriptions follow one another and fill the block.
    const std::uint64_t bits = 8 * static_cast<std::uint64_t>(info.block_bytes) / samples;
    for (std::uint64_t i = 0; i < samples; ++i) {
      EXPECT_EQ(number_at(bytes, descriptor_at + 28 + 16 * i, 2), bits * i) << i;
      EXPECT_EQ(number_at(bytes, descriptor_at + 30 + 16 * i, 1), bits - 1) << i;
    }
    EXPECT_EQ(number_at(bytes, 64, 8) + number_at(bytes, 72, 8), 0u);
    EXPECT_NE(bytes.find(std::string("KTXorientation\0rd\0", 18)), std::string::npos);
    // The smallest level comes first after the header. Each level begins at a multiple of its block size and of 4.
    std::uint64_t end = keys_at + keys;
    for (std::size_t level = 3; level-- > 0;) {
      const std::string expected = level_bytes_of(format, level);
      const std::size_t entry = 80 + 24 * level;
      const std::uint64_t at = number_at(bytes, entry, 8);
      EXPECT_EQ(number_at(bytes, entry + 8, 8), expected.size()) << level;
      EXPECT_EQ(number_at(bytes, entry + 16, 8), expected.size()) << level;
      EXPECT_GE(at, end) << level;
      EXPECT_LT(at, end + 16) << level;
      EXPECT_EQ(at % std::max<std::size_t>(4, static_cast<std::size_t>(info.block_bytes)), 0u) << level;
      for (std::uint64_t i = end; i < at; ++i) EXPECT_EQ(bytes.at(i), 0);
      EXPECT_EQ(bytes.substr(at, expected.size()), expected) << level;
      end = at + expected.size();
    }
    EXPECT_EQ(bytes.size(), end);
  }
}

TEST(TextureFile, Ktx2LevelsAreThereAgainAfterZstandard) {
  for (const TexelFormat format : kAllFormats)
    for (const int zstd_level : {1, kZstdLevelMax}) {
      SCOPED_TRACE(info_of(format).name);
      const std::string bytes = ktx2_bytes(format, {"rg11", zstd_level});
      EXPECT_EQ(number_at(bytes, 44, 4), 2u);  // Zstandard
      EXPECT_NE(bytes.find(std::string("KTXswizzle\0rg11\0", 16)), std::string::npos);
      std::uint64_t end = number_at(bytes, 56, 4) + number_at(bytes, 60, 4);
      for (std::size_t level = 3; level-- > 0;) {
        const std::string expected = level_bytes_of(format, level);
        const std::size_t entry = 80 + 24 * level;
        EXPECT_EQ(number_at(bytes, entry, 8), end) << level;  // without gaps
        const std::uint64_t length = number_at(bytes, entry + 8, 8);
        EXPECT_EQ(number_at(bytes, entry + 16, 8), expected.size()) << level;
        EXPECT_EQ(ZSTD_getFrameContentSize(bytes.data() + end, length), expected.size()) << level;
        std::string found(expected.size(), '\0');
        EXPECT_EQ(ZSTD_decompress(found.data(), found.size(), bytes.data() + end, length), expected.size()) << level;
        EXPECT_EQ(found, expected) << level;
        end += length;
      }
      EXPECT_EQ(bytes.size(), end);
    }
}

// The bytes of a frame with more than one piece do not depend on how many rows arrive at once.
TEST(TextureFile, ZstandardDoesNotDependOnRowsAtOnce) {
  const testing::TemporaryFolder folder;
  constexpr int kSide = 768;
  std::vector<std::uint8_t> texels(std::size_t{4} * kSide * kSide);
  for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = static_cast<std::uint8_t>(i * i / 1000 + i % 7);
  std::string first;
  for (const int rows : {1, 100, kSide}) {
    const std::string path = folder / "b.ktx2";
    const auto file = make_ktx2_file(path, {TexelFormat::kRgba8, kSide, kSide, 1}, {"", 3});
    for (int row = 0; row < kSide; row += rows)
      file->write_rows(0, std::min(rows, kSide - row),
                       texels.data() + std::size_t{4} * kSide * static_cast<unsigned>(row));
    file->finish();
    if (first.empty()) first = bytes_of(path);
    EXPECT_EQ(bytes_of(path), first) << rows;
  }
  EXPECT_LT(first.size(), texels.size() / 2);
}

TEST(TextureFile, DdsHasItsHeadAndItsLevels) {
  const testing::TemporaryFolder folder;
  for (const TexelFormat format : kAllFormats) {
    const TexelFormatInfo& info = info_of(format);
    SCOPED_TRACE(info.name);
    const std::string path = folder / "a.dds";
    write_texture(*make_dds_file(path, {format, 7, 5, 3}), format);
    const std::string bytes = bytes_of(path);
    EXPECT_EQ(bytes.substr(0, 4), "DDS ");
    EXPECT_EQ(number_at(bytes, 4, 4), 124u);
    EXPECT_EQ(number_at(bytes, 12, 4), 5u);
    EXPECT_EQ(number_at(bytes, 16, 4), 7u);
    EXPECT_EQ(number_at(bytes, 20, 4), info.block_side == 4 ? 4u * static_cast<unsigned>(info.block_bytes)
                                                            : 7u * static_cast<unsigned>(info.block_bytes));
    EXPECT_EQ(number_at(bytes, 28, 4), 3u);
    EXPECT_EQ(number_at(bytes, 76, 4), 32u);
    EXPECT_EQ(bytes.substr(84, 4), "DX10");
    EXPECT_EQ(number_at(bytes, 108, 4), 0x401008u);
    EXPECT_EQ(number_at(bytes, 128, 4), info.dxgi_format);
    EXPECT_EQ(number_at(bytes, 132, 4), 3u);
    EXPECT_EQ(number_at(bytes, 140, 4), 1u);
    EXPECT_EQ(bytes.substr(148), level_bytes_of(format, 0) + level_bytes_of(format, 1) + level_bytes_of(format, 2));
  }
}

TEST(TextureFile, LeavesNothingWithoutItsEnd) {
  const testing::TemporaryFolder folder;
  for (const int kind : {0, 1, 2}) {
    const LeveledTexture texture{TexelFormat::kRgba8, 2, 2, 2};
    const auto file = kind == 0 ? make_dds_file(folder / "c.dds", texture)
                                : make_ktx2_file(folder / "c.ktx2", texture, {"", kind == 1 ? 0 : 3});
    const std::vector<std::uint8_t> texels(16);
    file->write_rows(0, 2, texels.data());
  }
  EXPECT_TRUE(folder.names().empty());
  EXPECT_THROW(make_ktx2_file(folder / "no/c.ktx2", {}), Error);
  EXPECT_THROW(make_ktx2_file(folder / "no/c.ktx2", {}, {"", 3}), Error);
  EXPECT_THROW(make_dds_file(folder / "no/c.dds", {}), Error);
}

}  // namespace
}  // namespace multum
