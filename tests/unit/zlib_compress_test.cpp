// SPDX-License-Identifier: Apache-2.0
// What OpenEXR calls is ours, and zlib itself reads back what it writes.
#include "host/asset/zlib_compress.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

#include "host/base/split_mix.h"

namespace multum {
namespace {

using Bytes = std::vector<Bytef>;

// Of `values` different bytes: 1 compresses to nothing, 256 not at all.
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
  const Bytes source = random_bytes(262144, 16);  // 4 bits of 8
  for (int level = 1; level <= 9; ++level) EXPECT_LT(compressed(source, level).size(), source.size() * 6 / 10) << level;
}

// What lay on the stack before was ISA-L's table of earlier strings: other matches, other bytes, now and then.
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
