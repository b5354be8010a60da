// SPDX-License-Identifier: Apache-2.0
// Compares the stated number of bytes on the GPU with numbers that are computed by hand.
#include "host/formats/asset/gpu_bytes.h"

#include <gtest/gtest.h>

#include "tests/unit/formats/asset/movmf_test_mipmap.h"

namespace multum {
namespace {

TEST(GpuBytes, OfABakedFile) {
  // 8 x 4, 4 x 2, 2 x 1, 1 x 1: 43 texels.
  MovmfMipmap mipmap = testing::random_mipmap(8, 4, 3, false, StorageEncoding::kSnorm16, 1);
  EXPECT_EQ(movmf_gpu_bytes(mipmap), 43u * 3 * 8);
  mipmap.header.encoding = StorageEncoding::kHalf;
  EXPECT_EQ(movmf_gpu_bytes(mipmap), 43u * 3 * 8);
  mipmap.header.encoding = StorageEncoding::kFloat;
  EXPECT_EQ(movmf_gpu_bytes(mipmap), 43u * 3 * 16);
  drop_finer_levels(mipmap, 1);
  EXPECT_EQ(movmf_gpu_bytes(mipmap), 11u * 3 * 16);
  MovmfMipmap coloured = testing::random_mipmap(8, 4, 3, true, StorageEncoding::kSnorm16, 1);
  EXPECT_EQ(movmf_gpu_bytes(coloured), 43u * 3 * 16) << "colours have four channels on the GPU";
}

TEST(GpuBytes, OfWhatRenderersUsuallyHave) {
  // A block of 4 x 4 texels has 16 + 8 bytes, and partial blocks count as whole blocks. The levels have 9 x 5, 4 x 2, 2
  // x 1 and 1 x 1 texels.
  EXPECT_EQ(default_gpu_bytes(9, 5), (3u * 2 + 1 + 1 + 1) * 24);
  EXPECT_EQ(default_gpu_bytes(1, 1), 24u);
  // There are 1.5 bytes per texel, or 4/3 of that with mips. The levels of 2 x 2 and 1 x 1 texels take two more blocks.
  EXPECT_EQ(default_gpu_bytes(1024, 1024), (1024u * 1024 * 4 - 16) / 3 / 16 * 24 + 2 * 24);
}

}  // namespace
}  // namespace multum
