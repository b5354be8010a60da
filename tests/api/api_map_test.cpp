// SPDX-License-Identifier: Apache-2.0
// Tests reading baked maps through multum.h: views, regions, stored types and filtered lookups.
#include <algorithm>
#include <cstdint>

#include "tests/api/api_fixture.h"

namespace multum::testing {
namespace {

Owned<multum_map> baked(int size, const char* ndf, const char* format = nullptr) {
  const Owned<multum_device> device = open_device();
  const Owned<multum_values> values = bake_values();
  EXPECT_EQ(multum_values_set_text(values.get(), "ndf", ndf, nullptr), MULTUM_OK);
  if (format != nullptr) {
    EXPECT_EQ(multum_values_set_text(values.get(), "data_format", format, nullptr), MULTUM_OK);
  }
  const std::vector<float> pixels = wavy_normals(size);
  return bake(device.get(), image_of(pixels, size), values.get());
}

TEST(ApiMapTest, ViewHoldsEveryPartOfARepresentation) {
  struct Row {
    const char* ndf;
    std::vector<multum_part> parts;
  };
  for (const Row& row : {Row{"vmf", {MULTUM_LOBES}}, Row{"gmm", {MULTUM_LOBES}},
                         Row{"moments", {MULTUM_SLOPES, MULTUM_MEAN_NORMALS}}, Row{"sh", {MULTUM_HARMONICS}}}) {
    const Owned<multum_map> map = baked(16, row.ndf);
    EXPECT_STREQ(multum_map_text(map.get(), "representation"), row.ndf);
    const multum_info info = multum_map_info(map.get());
    EXPECT_EQ(info.level_count, 5);
    for (int level = info.first_level; level < info.level_count; ++level)
      for (int part = MULTUM_LOBES; part <= MULTUM_HARMONICS; ++part) {
        const bool is_held = std::find(row.parts.begin(), row.parts.end(), part) != row.parts.end();
        const multum_view shape = multum_map_shape(map.get(), level, static_cast<multum_part>(part));
        multum_view view = {};
        const multum_status status = multum_map_level(map.get(), level, static_cast<multum_part>(part), &view, nullptr);
        EXPECT_EQ(status, is_held ? MULTUM_OK : MULTUM_BAD_SETTING) << row.ndf << " part " << part;
        EXPECT_EQ(shape.layers > 0, is_held);
        if (!is_held) continue;
        EXPECT_EQ(view.width, std::max(1, 16 >> level));
        for (int i = 0; i < view.layers * view.height * view.width * view.channels; ++i)
          ASSERT_TRUE(std::isfinite(view.values[i]));
      }
  }
}

TEST(ApiMapTest, AmplitudesOfATexelSumToOne) {
  const Owned<multum_map> map = baked(16, "vmf");
  multum_view view = {};
  ASSERT_EQ(multum_map_level(map.get(), 2, MULTUM_LOBES, &view, nullptr), MULTUM_OK);
  const int texels = view.width * view.height;
  for (int i = 0; i < texels; ++i) {
    double sum = 0.0;
    for (int j = 0; j < view.layers; ++j) sum += static_cast<double>(view.values[(j * texels + i) * 4 + 3]);
    EXPECT_NEAR(sum, 1.0, 1e-6);
  }
}

TEST(ApiMapTest, SecondViewIsTheSameMemory) {
  const Owned<multum_map> map = baked(16, "vmf");
  multum_view first = {}, second = {};
  ASSERT_EQ(multum_map_level(map.get(), 1, MULTUM_LOBES, &first, nullptr), MULTUM_OK);
  ASSERT_EQ(multum_map_level(map.get(), 1, MULTUM_LOBES, &second, nullptr), MULTUM_OK);
  EXPECT_EQ(first.values, second.values);
}

TEST(ApiMapTest, RegionIsACropOfTheLevel) {
  const Owned<multum_map> map = baked(64, "vmf");
  multum_view level = {};
  ASSERT_EQ(multum_map_level(map.get(), 1, MULTUM_LOBES, &level, nullptr), MULTUM_OK);
  const multum_region region = {5, 9, 7, 11};
  const std::size_t count = static_cast<std::size_t>(level.layers * 7 * 11 * 4);
  std::vector<float> values(count, -9.0f);
  std::vector<std::int16_t> stored(count);
  ASSERT_EQ(multum_map_read(map.get(), 1, MULTUM_LOBES, region, MULTUM_FLOAT, values.data(), nullptr), MULTUM_OK);
  ASSERT_EQ(multum_map_read(map.get(), 1, MULTUM_LOBES, region, MULTUM_SNORM16, stored.data(), nullptr), MULTUM_OK);
  std::size_t at = 0;
  for (int j = 0; j < level.layers; ++j)
    for (int y = 9; y < 20; ++y)
      for (int x = 5; x < 12; ++x)
        for (int c = 0; c < 4; ++c, ++at) {
          ASSERT_EQ(values[at], level.values[((j * level.height + y) * level.width + x) * 4 + c]);
          // These values are exact multiples of 1/32767.
          ASSERT_EQ(static_cast<float>(stored[at]) / 32767.0f, values[at]);
        }
}

TEST(ApiMapTest, HalvesAreExactForHalfFiles) {
  const Owned<multum_map> map = baked(16, "sh", "half");
  multum_view level = {};
  ASSERT_EQ(multum_map_level(map.get(), 1, MULTUM_HARMONICS, &level, nullptr), MULTUM_OK);
  const std::size_t count = static_cast<std::size_t>(level.layers * level.height * level.width * level.channels);
  std::vector<std::uint16_t> stored(count);
  ASSERT_EQ(multum_map_read(map.get(), 1, MULTUM_HARMONICS, {0, 0, level.width, level.height}, MULTUM_HALF,
                            stored.data(), nullptr),
            MULTUM_OK);
  for (std::size_t i = 0; i < count; ++i) {  // decodes a 16-bit float that is normal or zero
    const int exponent = (stored[i] >> 10) & 31, mantissa = stored[i] & 1023;
    const double size = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
    ASSERT_EQ(static_cast<double>(level.values[i]), (stored[i] & 0x8000) != 0 ? -size : size);
  }
}

TEST(ApiMapTest, RegionOutsideOfTheLevelIsRefused) {
  const Owned<multum_map> map = baked(16, "vmf");
  std::vector<float> values(100000);
  for (const multum_region region : {multum_region{-1, 0, 2, 2}, multum_region{0, 0, 9, 1}, multum_region{0, 0, 0, 1},
                                     multum_region{7, 7, 2, 1}, multum_region{1, 1, 2147483647, 2147483647}})
    EXPECT_EQ(multum_map_read(map.get(), 1, MULTUM_LOBES, region, MULTUM_FLOAT, values.data(), nullptr),
              MULTUM_BAD_SETTING);
  EXPECT_EQ(multum_map_read(map.get(), 9, MULTUM_LOBES, {0, 0, 1, 1}, MULTUM_FLOAT, values.data(), nullptr),
            MULTUM_BAD_SETTING);
}

TEST(ApiMapTest, LookupAtATexelIsTheTexelAndBetweenLevelsTheirMean) {
  const Owned<multum_map> map = baked(16, "vmf");
  multum_view fine = {}, coarse = {};
  ASSERT_EQ(multum_map_level(map.get(), 1, MULTUM_LOBES, &fine, nullptr), MULTUM_OK);
  ASSERT_EQ(multum_map_level(map.get(), 4, MULTUM_LOBES, &coarse, nullptr), MULTUM_OK);
  multum_lobes lobes;
  ASSERT_EQ(multum_map_lookup(map.get(), (3 + 0.5) / 8, (5 + 0.5) / 8, 1.0, &lobes, nullptr), MULTUM_OK);
  for (int j = 0; j < lobes.count; ++j)
    for (int c = 0; c < 4; ++c) EXPECT_EQ(lobes.lobes[j][c], fine.values[((j * 8 + 5) * 8 + 3) * 4 + c]);
  // The map repeats, so a lookup half a texel beyond the last column returns the mean of the last and the first column.
  ASSERT_EQ(multum_map_lookup(map.get(), 3.0, (5 + 0.5) / 8, 1.0, &lobes, nullptr), MULTUM_OK);
  for (int j = 0; j < lobes.count; ++j)
    for (int c = 0; c < 4; ++c)
      EXPECT_NEAR(lobes.lobes[j][c],
                  0.5f * (fine.values[((j * 8 + 5) * 8 + 7) * 4 + c] + fine.values[((j * 8 + 5) * 8 + 0) * 4 + c]),
                  1e-6f);
  ASSERT_EQ(multum_map_lookup(map.get(), 0.2, 0.7, 99.0, &lobes, nullptr), MULTUM_OK);
  for (int j = 0; j < lobes.count; ++j)
    for (int c = 0; c < 4; ++c) EXPECT_NEAR(lobes.lobes[j][c], coarse.values[j * 4 + c], 1e-6f);
  EXPECT_EQ(multum_map_lookup(map.get(), std::nan(""), 0.0, 0.0, &lobes, nullptr), MULTUM_BAD_SETTING);
}

}  // namespace
}  // namespace multum::testing
