// SPDX-License-Identifier: Apache-2.0
// Tests that OpenEXR calls our uncompress function, and that the function returns the same results as zlib.
#include "host/formats/decoder/zlib_uncompress.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <vector>

namespace multum {
namespace {

TEST(ZlibUncompressTest, AnswersAsZlib) {
  ASSERT_TRUE(replaces_zlib_uncompress());
  const std::vector<Bytef> source(100000, 7);
  std::vector<Bytef> packed(compressBound(source.size())), unpacked(source.size() + 5, 0xA5);
  uLongf packed_size = packed.size();
  ASSERT_EQ(compress(packed.data(), &packed_size, source.data(), source.size()), Z_OK);
  uLongf size = unpacked.size();
  ASSERT_EQ(uncompress(unpacked.data(), &size, packed.data(), packed_size), Z_OK);
  EXPECT_EQ(size, source.size());
  EXPECT_TRUE(std::equal(source.begin(), source.end(), unpacked.begin()));
  EXPECT_EQ(unpacked.back(), 0xA5);
  size = source.size() - 1;
  EXPECT_EQ(uncompress(unpacked.data(), &size, packed.data(), packed_size), Z_BUF_ERROR);
  size = unpacked.size();
  EXPECT_EQ(uncompress(unpacked.data(), &size, packed.data(), packed_size - 1), Z_DATA_ERROR);
  packed[packed_size / 2] ^= 0x20;
  size = unpacked.size();
  EXPECT_EQ(uncompress(unpacked.data(), &size, packed.data(), packed_size), Z_DATA_ERROR);
}

}  // namespace
}  // namespace multum
