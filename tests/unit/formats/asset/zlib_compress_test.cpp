// SPDX-License-Identifier: Apache-2.0
// Tests that OpenEXR calls our zlib functions, and that zlib itself reads what they write.
#include "host/formats/asset/exr/zlib_compress.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

using Bytes = std::vector<Bytef>;

// Makes bytes with `values` different values. With 1 value, the compressed size is almost 0. With 256 values, the bytes
// cannot be compressed.
Bytes random_bytes(std::size_t count, std::uint64_t values) {
  Bytes bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<Bytef>(split_mix(i) % values);
  return bytes;
}

Bytes compressed(const Bytes& source, int level) {
  Bytes to(compressBound(source.size()));
  uLongf size = to.size();
  EXPECT_EQ(compress2(to.data(), &size, source.data(), source.size(), level), Z_OK);
  to.resize(size);
  return to;
}

TEST(ZlibCompressTest, ZlibReadsEveryLevel) {
  ASSERT_TRUE(replaces_zlib_compress());
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{1000}, std::size_t{262144}})
    for (const std::uint64_t values : {1u, 7u, 256u}) {
      const Bytes source = random_bytes(count, values);
      for (int level = -1; level <= 9; ++level) {
        const Bytes packed = compressed(source, level);
        Bytes back(count + 1);
        uLongf size = back.size();
        ASSERT_EQ(uncompress(back.data(), &size, packed.data(), packed.size()), Z_OK) << level << " " << count;
        back.resize(size);
        EXPECT_EQ(back, source);
      }
    }
}

TEST(ZlibCompressTest, QuickLevelsCompressToo) {
  const Bytes source = random_bytes(262144, 16);  // 4 of 8 bits are random
  for (int level = 1; level <= 9; ++level) EXPECT_LT(compressed(source, level).size(), source.size() * 6 / 10) << level;
}

// ISA-L read the size of its window from uninitialised stack memory, so matches and bytes sometimes differed.
[[gnu::noinline]] void fill_the_stack(std::uint64_t seed) {
  volatile std::uint16_t there[1 << 18];
  for (std::size_t i = 0; i < std::size(there); ++i) there[i] = static_cast<std::uint16_t>(split_mix(seed + i) % 64);
}

TEST(ZlibCompressTest, SameBytesWhateverWasInMemory) {
  for (const std::size_t count : {std::size_t{36}, std::size_t{200}, std::size_t{20000}})
    for (const int level : {1, 3, 4, 9}) {
      const Bytes source = random_bytes(count, 5);
      fill_the_stack(0);
      const Bytes first = compressed(source, level);
      for (std::uint64_t seed = 1; seed < 20; ++seed) {
        fill_the_stack(seed << 20);
        ASSERT_EQ(compressed(source, level), first) << count << " bytes, level " << level << ", " << seed;
      }
    }
}

// Compresses with the stack `depth` times 64 KiB deeper.
[[gnu::noinline]] Bytes compressed_below(const Bytes& source, int level, int depth) {
  volatile std::uint64_t page[8192];
  page[0] = static_cast<std::uint64_t>(depth);
  Bytes found = depth > 0 ? compressed_below(source, level, depth - 1) : compressed(source, level);
  page[8191] = page[0];
  return found;
}

// ISA-L 2.30 hashes strings with the address of its stream, in units of 64 KiB. Short inputs have small tables of
// strings, so that 1 in 500 gave other bytes at another address. In this test, about 25 results differed.
TEST(ZlibCompressTest, SameBytesWhereverTheStackIs) {
  constexpr int kDepths = 24;
  for (std::uint64_t input = 0; input < 500; ++input) {
    Bytes source(18 + split_mix(input) % 110);
    for (std::size_t i = 0; i < source.size(); ++i)
      source[i] = static_cast<Bytef>(split_mix((input << 32) + i) % (2 + input % 7));
    const Bytes first = compressed_below(source, 1, 0);
    for (int depth = 1; depth <= kDepths; ++depth)
      ASSERT_EQ(compressed_below(source, 1, depth), first) << "input " << input << ", depth " << depth;
  }
}

TEST(ZlibCompressTest, TooLittleRoomIsAnError) {
  const Bytes source = random_bytes(10000, 256);
  for (const int level : {1, 3, 4, 9}) {
    Bytes to(5000);
    uLongf size = to.size();
    EXPECT_EQ(compress2(to.data(), &size, source.data(), source.size(), level), Z_BUF_ERROR);
  }
}

}  // namespace
}  // namespace multum
