// SPDX-License-Identifier: Apache-2.0
// Measured errors of files that leave their finest levels to the normal map, on maps whose errors are known.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <random>

#include "host/bake/accuracy.h"
#include "host/bake/mip_coverage.h"
#include "tests/reference/test_maps.h"

namespace multum {
namespace {

constexpr int kWidth = 22, kHeight = 9;  // levels of 22 x 9, 11 x 4, 5 x 2, 2 x 1, 1 x 1

double uniform(std::mt19937& random) { return static_cast<double>(random() >> 8) * 0x1p-24 * 2.0 - 1.0; }

NormalMap random_map(unsigned seed, double slope) {
  std::mt19937 random(seed);
  return testing::make_map(kWidth, kHeight, [&](int, int) {
    const double x = slope * uniform(random), y = slope * uniform(random);
    return glm::normalize(glm::dvec3(x, y, 1.0));
  });
}

ColourMap random_colours(unsigned seed, double contrast) {
  std::mt19937 random(seed);
  ColourMap map;
  map.width = kWidth;
  map.height = kHeight;
  for (int i = 0; i < kWidth * kHeight; ++i)
    for (std::vector<float>* plane : {&map.r, &map.g, &map.b})
      plane->push_back(static_cast<float>(0.5 + 0.5 * contrast * uniform(random)));
  return map;
}

// One lobe a texel: the average of what it covers, in every level. So do the levels that a file leaves out look.
MovmfMipmap average_lobes(const NormalMap& map, const ColourMap& albedo) {
  MovmfMipmap mipmap;
  mipmap.encoding = StorageEncoding::kFloat;
  for (int l = 0; l < mip_level_count(kWidth, kHeight); ++l) {
    MovmfLevel level{mip_level_size(kWidth, l), mip_level_size(kHeight, l), {{}}, {{}}};
    for (int i = 0; i < level.width * level.height; ++i) {
      const auto average = [&](const std::array<const std::vector<float>*, 3>& planes) {
        return glm::vec3(average_over_texel(planes, {kWidth, kHeight}, {level.width, level.height}, i));
      };
      level.lobes[0].emplace_back(average({&map.x, &map.y, &map.z}), 1.0f);
      level.colours[0].push_back(average({&albedo.r, &albedo.g, &albedo.b}));
    }
    mipmap.levels.push_back(std::move(level));
  }
  return mipmap;
}

std::vector<AccuracyRow> measure(MovmfMipmap mipmap, int first_level, const NormalMap& map, const ColourMap& albedo) {
  static Device device = Device::open("");
  drop_finer_levels(mipmap, first_level);
  AccuracySettings settings;
  settings.samples_per_level = 0;
  settings.albedo = &albedo;
  return measure_accuracy(device, mipmap, map, settings, nullptr);
}

TEST(FirstLevelAccuracy, IsThatOfTheNormalMapsOwnLevels) {
  const NormalMap map = random_map(1, 0.6);
  const ColourMap albedo = random_colours(2, 1.0);
  const MovmfMipmap mipmap = average_lobes(map, albedo);
  const std::vector<AccuracyRow> whole = measure(mipmap, 0, map, albedo);
  for (const int first_level : {1, 2, 4}) {
    const std::vector<AccuracyRow> coarse = measure(mipmap, first_level, map, albedo);
    ASSERT_EQ(coarse.size(), whole.size());
    bool mixes = false;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      EXPECT_EQ(coarse[i].level, whole[i].level);
      EXPECT_EQ(coarse[i].sample_count, whole[i].sample_count);
      if (whole[i].level == first_level - 1 && whole[i].point == AccuracyPoint::kBetween) {
        // Two shaded lobes, mixed, are not the mixed lobe, shaded.
        mixes = mixes || std::abs(coarse[i].error - whole[i].error) > 1e-4;
      } else {
        EXPECT_NEAR(coarse[i].error, whole[i].error, 2e-6)
            << "level " << whole[i].level << " " << accuracy_point_name(whole[i].point) << " " << whole[i].brdf;
      }
    }
    EXPECT_TRUE(mixes);
  }
}

// Where shading is linear in the mean vector, and where nothing but colours varies, every mixture is exact: all
// weights, those between the normal map and the lobes too, show in the error.
TEST(FirstLevelAccuracy, LinearShadingIsExactAcrossTheTransition) {
  const NormalMap mild = random_map(3, 0.1);
  const ColourMap grey = random_colours(4, 0.0);
  const NormalMap flat = random_map(4, 0.0);
  const ColourMap colours = random_colours(5, 1.0);
  for (const int first_level : {0, 1, 2, 3}) {
    for (const AccuracyRow& row : measure(average_lobes(mild, grey), first_level, mild, grey))
      if (row.brdf.starts_with("lambert")) {
        EXPECT_LT(row.error, 3e-4) << first_level << ": level " << row.level << " " << accuracy_point_name(row.point);
      }
    for (const AccuracyRow& row : measure(average_lobes(flat, colours), first_level, flat, colours))
      EXPECT_LT(row.error, 3e-6) << first_level << ": level " << row.level << " " << accuracy_point_name(row.point)
                                 << " " << row.brdf;
  }
}

}  // namespace
}  // namespace multum
