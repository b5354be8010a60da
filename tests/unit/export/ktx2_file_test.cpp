// SPDX-License-Identifier: Apache-2.0
// KTX2 files by their bytes: the head's fields where the specification has them, levels aligned and the smallest first.
// tests/cli/export_command_test.cpp has ktx-parse read them.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "host/base/error.h"
#include "host/export/ktx2_file.h"
#include "tests/unit/base/test_folder.h"

namespace multum {
namespace {

std::uint64_t number_at(const std::string& bytes, std::size_t at, std::size_t byte_count) {
  std::uint64_t value = 0;
  for (std::size_t i = byte_count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
  return value;
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Every byte of level l is 10 l + the row that it is in.
std::string write_texture(const std::string& path, const Ktx2Texture& texture) {
  Ktx2File file(path, texture);
  EXPECT_FALSE(std::filesystem::exists(path)) << "before finish()";
  int row = 0;
  // Rows of levels mixed, as an export has them.
  for (bool has_more = true; has_more; ++row) {
    has_more = false;
    for (int level = 0; level < texture.level_count; ++level) {
      const int width = std::max(1, texture.width >> level), height = std::max(1, texture.height >> level);
      if (row >= height) continue;
      const std::vector<std::uint8_t> texels(static_cast<std::size_t>(width) * texel_bytes(texture.format),
                                             static_cast<std::uint8_t>(10 * level + row));
      file.write_rows(level, 1, texels.data());
      has_more = true;
    }
  }
  file.finish();
  return bytes_of(path);
}

TEST(Ktx2File, HasItsHeadAndItsLevels) {
  const testing::TemporaryFolder folder;
  for (const Ktx2Format format : {Ktx2Format::kRg8, Ktx2Format::kRgba8, Ktx2Format::kRgba16f}) {
    const Ktx2Texture texture{format, 7, 5, 3};
    const std::string bytes = write_texture(folder / ("a" + std::to_string(texel_bytes(format)) + ".ktx2"), texture);
    EXPECT_EQ(bytes.substr(0, 12), std::string("\xabKTX 20\xbb\r\n\x1a\n"));
    const std::size_t texel = texel_bytes(format);
    const std::uint64_t vk_format = format == Ktx2Format::kRg8 ? 16u : format == Ktx2Format::kRgba8 ? 37u : 97u;
    const std::uint64_t fields[] = {vk_format, format == Ktx2Format::kRgba16f ? 2u : 1u, 7, 5, 0, 0, 1, 3, 0};
    for (std::size_t i = 0; i < std::size(fields); ++i) EXPECT_EQ(number_at(bytes, 12 + 4 * i, 4), fields[i]) << i;
    const std::uint64_t descriptor_at = number_at(bytes, 48, 4), descriptor = number_at(bytes, 52, 4);
    const std::uint64_t keys_at = number_at(bytes, 56, 4), keys = number_at(bytes, 60, 4);
    EXPECT_EQ(descriptor_at, 80u + 3u * 24u);
    EXPECT_EQ(keys_at, descriptor_at + descriptor);
    EXPECT_EQ(number_at(bytes, descriptor_at, 4), descriptor);
    EXPECT_EQ(descriptor, 28u + 16u * (format == Ktx2Format::kRg8 ? 2u : 4u));
    EXPECT_EQ(number_at(bytes, 64, 8) + number_at(bytes, 72, 8), 0u);
    EXPECT_NE(bytes.find(std::string("KTXorientation\0rd\0", 18)), std::string::npos);
    // The smallest level is nearest to the head; each begins at a multiple of its texel and of 4.
    std::uint64_t end = keys_at + keys;
    const int sizes[][2] = {{7, 5}, {3, 2}, {1, 1}};
    for (int level = 2; level >= 0; --level) {
      const std::size_t entry = 80 + 24 * static_cast<std::size_t>(level);
      const std::uint64_t at = number_at(bytes, entry, 8), length = number_at(bytes, entry + 8, 8);
      const std::size_t row = static_cast<std::size_t>(sizes[level][0]) * texel;
      EXPECT_EQ(length, row * static_cast<std::size_t>(sizes[level][1])) << level;
      EXPECT_EQ(number_at(bytes, entry + 16, 8), length) << level;
      EXPECT_GE(at, end) << level;
      EXPECT_LT(at, end + 8) << level;
      EXPECT_EQ(at % std::max<std::size_t>(4, texel), 0u) << level;
      for (std::uint64_t i = end; i < at; ++i) EXPECT_EQ(bytes.at(i), 0);
      for (std::uint64_t i = 0; i < length; ++i)
        ASSERT_EQ(static_cast<std::uint64_t>(static_cast<unsigned char>(bytes.at(at + i))),
                  10u * static_cast<unsigned>(level) + i / row);
      end = at + length;
    }
    EXPECT_EQ(bytes.size(), end);
  }
}

TEST(Ktx2File, LeavesNothingWithoutItsEnd) {
  const testing::TemporaryFolder folder;
  {
    Ktx2File file(folder / "b.ktx2", {Ktx2Format::kRgba8, 2, 2, 2});
    const std::vector<std::uint8_t> texels(16);
    file.write_rows(0, 2, texels.data());
  }
  EXPECT_TRUE(folder.names().empty());
  EXPECT_THROW(Ktx2File(folder / "no/b.ktx2", {}), Error);
}

}  // namespace
}  // namespace multum
