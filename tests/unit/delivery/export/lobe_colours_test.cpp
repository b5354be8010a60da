// SPDX-License-Identifier: Apache-2.0
// Tests tints. The tint of a lobe is its colour relative to the colour of the texel, and the tints of a texel add up to
// 0. A file of tints is written only if the map has enough levels.
#include "host/delivery/export/lobes/lobe_colours.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/fixtures/test_device.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

// Makes two lobes with amplitudes 1/4 and 3/4. The first lobe is `times` as bright as the second.
MovmfMipmap coloured_mipmap(int side, float times) {
  MovmfMipmap mipmap;
  for (int s = side; s > 0; s /= 2) {
    const std::size_t texels = static_cast<std::size_t>(s) * static_cast<std::size_t>(s);
    MovmfLevel level{s, s, {}, {}};
    for (const float a : {0.25f, 0.75f}) {
      const glm::vec3 normal = a < 0.5f ? glm::vec3(0.6f, 0.0f, 0.8f) : glm::vec3(0.0f, 0.0f, 1.0f);
      level.lobes.emplace_back(texels, a * glm::vec4(0.9f * normal, 1.0f));
      level.colours.emplace_back(texels, a * (a < 0.5f ? times : 1.0f) * glm::vec3(0.2f, 0.1f, 0.05f));
    }
    mipmap.levels.push_back(std::move(level));
  }
  mipmap.header.first_level = 1;
  drop_finer_levels(mipmap, 1);
  mipmap.header = full_header(mipmap);
  return mipmap;
}

TEST(LobeColours, TintsAddUpToNothing) {
  const auto tints = lobe_tints(coloured_mipmap(8, 2.0f).levels[1]);
  ASSERT_EQ(tints.size(), 2u);
  // The brightness of the texel is 2/4 + 3/4 = 5/4, so the factors are 8/5 and 4/5.
  for (std::size_t i = 0; i < tints[0].size(); ++i) {
    EXPECT_NEAR(tints[0][i], 0.25f * 0.6f, 1e-6f);
    EXPECT_NEAR(tints[1][i], -0.75f * 0.2f, 1e-6f);
  }
}

TEST(LobeColours, BlackAndFaintLobesHaveTintsWithinBounds) {
  for (const auto& of_lobe : lobe_tints(coloured_mipmap(4, 0.0f).levels[1]))
    for (const float tint : of_lobe) EXPECT_LE(std::abs(tint), 0.26f);
  // First a quarter and then a hundredth of the normals reflect all of the light of the texel. Factors are limited to
  // four times the luminance of the texel.
  MovmfLevel bright = coloured_mipmap(4, 1000.0f).levels[1];
  EXPECT_NEAR(lobe_tints(bright)[0][0], 0.25f * 3.0f, 5e-3f);
  bright.lobes[0][0] *= 0.04f;
  bright.colours[0][0] *= 0.04f;
  bright.colours[1][0] *= 0.0f;
  EXPECT_NEAR(lobe_tints(bright)[0][0], 0.01f * 3.0f, 1e-5f);
  MovmfLevel black = coloured_mipmap(4, 1.0f).levels[1];
  for (auto& of_lobe : black.colours) of_lobe.assign(of_lobe.size(), glm::vec3(0.0f));
  for (const auto& of_lobe : lobe_tints(black))
    for (const float tint : of_lobe) EXPECT_EQ(tint, 0.0f);
}

TEST(LobeColours, AFileHasTheLevelsFromTheSecondOn) {
  const testing::TemporaryFolder folder;
  const std::string baked = folder.path() + "/baked.ndf.exr", out = folder.path() + "/colours.ktx2";
  for (const int side : {16, 2}) {
    write_movmf_mipmap(baked, coloured_mipmap(side, 2.0f), {});
    std::filesystem::remove(out);
    const std::uint64_t bytes = export_lobe_colours({baked, out, 0, 1}, testing::test_device(), nullptr);
    EXPECT_EQ(bytes > 0, side > 2) << side;
    EXPECT_EQ(std::filesystem::exists(out), side > 2) << side;
    EXPECT_EQ(side > 2 ? std::filesystem::file_size(out) : 0, bytes);
  }
}

}  // namespace
}  // namespace multum
