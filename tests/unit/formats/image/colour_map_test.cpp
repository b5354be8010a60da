// SPDX-License-Identifier: Apache-2.0
// Tests that albedos are linear. Integers are decoded as sRGB or as the file says, and floats are not changed.
#include "host/formats/image/colour_map.h"

#include <limits>

#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;

TestImage colour_image(TypeDesc::BASETYPE type, const std::string& colour_space) {
  return {.width = 2,
          .height = 1,
          .values = {0.0f, 0.2f, 0.5f, 0.6f, 0.8f, 1.0f},
          .type = type,
          .colour_space = colour_space};
}

TEST(AlbedoReading, IntegersAreSrgb) {
  const TemporaryFolder folder;
  for (const TypeDesc::BASETYPE type : {TypeDesc::UINT8, TypeDesc::UINT16}) {
    for (const char* name : {"a.png", "a.tif"}) {
      write_test_image(folder / name, colour_image(type, "sRGB"));
      const ColourMap map = read_albedo_map(folder / name, 2, 1, 2);
      EXPECT_EQ(map.r[0], 0.0f);
      EXPECT_NEAR(map.b[0], 0.21404, 0.003) << name;  // sRGB 0.5
      EXPECT_NEAR(map.b[1], 1.0, 1e-6);
      EXPECT_NE(map.format.find("sRGB"), std::string::npos) << map.format;
    }
  }
}

TEST(AlbedoReading, LinearIntegersAndFloatsStay) {
  const TemporaryFolder folder;
  write_test_image(folder / "a.png", colour_image(TypeDesc::UINT16, "Linear"));
  EXPECT_NEAR(read_albedo_map(folder / "a.png", 2, 1, 1).b[0], 0.5, 1e-4);
  write_test_image(folder / "a.exr", colour_image(TypeDesc::FLOAT, ""));
  const ColourMap map = read_albedo_map(folder / "a.exr", 2, 1, 1);
  EXPECT_EQ(map.g[1], 0.8f);
  EXPECT_EQ(map.clamped_count, 0);
}

TEST(AlbedoReading, GreyBecomesRgbAndInvalidValuesBlack) {
  const TemporaryFolder folder;
  TestImage image{.width = 4, .height = 1, .channels = 1, .type = TypeDesc::FLOAT, .channel_names = {"Y"}};
  image.values = {0.25f, -1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
  write_test_image(folder / "a.exr", image);
  const ColourMap map = read_albedo_map(folder / "a.exr", 4, 1, 1);
  EXPECT_EQ(map.r, (std::vector<float>{0.25f, 0.0f, 0.0f, 0.0f}));
  EXPECT_EQ(map.r, map.g);
  EXPECT_EQ(map.r, map.b);
  EXPECT_EQ(map.clamped_count, 3);
}

TEST(AlbedoReading, AnotherSizeIsRefusedNamingBoth) {
  const TemporaryFolder folder;
  write_test_image(folder / "a.png", colour_image(TypeDesc::UINT8, ""));
  expect_error(ErrorCode::kInput, {"a.png", "2 x 1", "4 x 4"}, [&] { read_albedo_map(folder / "a.png", 4, 4, 1); });
}

TEST(AlbedoReading, TransferFunctionsAreInverse) {
  for (int i = 0; i <= 1000; ++i) EXPECT_NEAR(srgb_from_linear(linear_from_srgb(i / 1000.0)), i / 1000.0, 1e-7);
}

}  // namespace
}  // namespace multum::testing
