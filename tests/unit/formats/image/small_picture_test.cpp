// SPDX-License-Identifier: Apache-2.0
// Tests that the pixels of small pictures are means over areas. Each pixel of the original counts by the fraction of it
// that is covered.
#include "host/formats/image/small_picture.h"

#include <numeric>

#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;

TEST(SmallPicture, PixelsAreMeansOverTheirAreas) {
  const TemporaryFolder folder;
  // Three columns become two columns. Each of them gets half of the middle column.
  write_test_image(folder / "a.png", {.width = 3,
                                      .height = 1,
                                      .values = {0.0f, 0.0f, 0.0f, 0.6f, 0.6f, 0.6f, 0.0f, 1.0f, 0.2f},
                                      .type = TypeDesc::UINT16});
  const Png8Image picture = read_small_picture(folder / "a.png", 2);
  EXPECT_EQ(picture.width, 2);
  EXPECT_EQ(picture.height, 1);
  const std::vector<std::uint8_t> expected = {51, 51, 51, 51, 221, 85};  // 255 (1 c0 + 0.5 c1) / 1.5, and so on
  EXPECT_EQ(picture.interleaved, expected);
}

TEST(SmallPicture, KeepsMeansAndRatiosOfAnySize) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair(7, 5), std::pair(64, 3), std::pair(3, 64), std::pair(33, 17)}) {
    TestImage image{.width = width, .height = height, .type = TypeDesc::UINT8};
    for (int i = 0; i < 3 * width * height; ++i) image.values.push_back(static_cast<float>((i * 7919) % 256) / 255.0f);
    write_test_image(folder / "a.png", image);
    const Png8Image picture = read_small_picture(folder / "a.png", 5);
    EXPECT_EQ(std::max(picture.width, picture.height), 5);
    const auto mean = [](const auto& values) {
      return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    };
    EXPECT_NEAR(mean(picture.interleaved), 255.0 * mean(image.values), 0.5) << width << " x " << height;
    const Png8Image whole = read_small_picture(folder / "a.png", 64);
    EXPECT_EQ(whole.width, width);
    EXPECT_NEAR(mean(whole.interleaved), 255.0 * mean(image.values), 1e-3);
  }
}

TEST(SmallPicture, OtherRangesAreMadeVisible) {
  const TemporaryFolder folder;
  write_test_image(folder / "signed.exr",
                   {.width = 1, .height = 1, .values = {-1.0f, 0.0f, 1.0f}, .type = TypeDesc::FLOAT});
  const std::vector<std::uint8_t> normal = {0, 128, 255};
  EXPECT_EQ(read_small_picture(folder / "signed.exr", 8).interleaved, normal);
  write_test_image(
      folder / "height.png",
      {.width = 3, .height = 1, .channels = 1, .values = {0.500f, 0.502f, 0.504f}, .type = TypeDesc::UINT16});
  const std::vector<std::uint8_t> stretched = {0, 128, 255};
  const Png8Image height = read_small_picture(folder / "height.png", 8);
  EXPECT_EQ(height.channels, 1);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(height.interleaved[i], stretched[i], 2);
}

TEST(SmallPicture, WhatIsNoPictureIsRefused) {
  const TemporaryFolder folder;
  expect_error(ErrorCode::kInput, {"none.png"}, [&] { read_small_picture(folder / "none.png", 8); });
}

}  // namespace
}  // namespace multum::testing
