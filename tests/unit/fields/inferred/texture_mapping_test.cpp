// SPDX-License-Identifier: Apache-2.0
// Tests the index of each texel in the list of a pyramid, and the position of an object's own texture coordinates in
// its texture.
#include "host/fields/inferred/texture_mapping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/formats/asset/mip_layout.h"
#include "tests/unit/fields/inferred/inference_assets.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::expect_same;
using testing::unusual_mapping;

// ---- MipLayout

TEST(MipLayoutTest, SidesAreHalvedAndRoundedDown) {
  const MipLayout layout(5, 3);
  ASSERT_EQ(layout.level_count(), 3);
  const int expected[3][3] = {{5, 3, 0}, {2, 1, 15}, {1, 1, 17}};  // width, height, first texel
  for (std::size_t l = 0; l < 3; ++l) {
    EXPECT_EQ(layout.levels[l].width, expected[l][0]) << l;
    EXPECT_EQ(layout.levels[l].height, expected[l][1]) << l;
    EXPECT_EQ(layout.levels[l].offset, expected[l][2]) << l;
  }
  EXPECT_EQ(layout.texel_count, 18);
  EXPECT_EQ(MipLayout().level_count(), 0);
  EXPECT_EQ(MipLayout().texel_count, 0);
  EXPECT_EQ(MipLayout(1, 1).level_count(), 1);
  EXPECT_EQ(MipLayout(1, 1).texel_count, 1);
  EXPECT_EQ(MipLayout(1, 9).level_count(), 4);
  EXPECT_EQ(MipLayout(1, 9).texel_count, 9 + 4 + 2 + 1);
  EXPECT_EQ(MipLayout(16384, 16384).level_count(), 15);
  EXPECT_EQ(MipLayout(16384, 16384).texel_count, ((1 << 30) - 1) / 3);  // 1 + 4 + ... + 2^28
}

TEST(MipLayoutTest, EveryTexelIsOfTheLevelThatItIsCountedIn) {
  for (int height = 1; height <= 17; ++height)
    for (int width = 1; width <= 17; ++width) {
      const MipLayout layout(width, height);
      int texel = 0;
      for (int l = 0; l < layout.level_count(); ++l) {
        const int count = std::max(1, width >> l) * std::max(1, height >> l);
        for (int i = 0; i < count; ++i, ++texel) ASSERT_EQ(layout.level_of(texel), l) << width << " x " << height;
      }
      ASSERT_EQ(texel, layout.texel_count);
      ASSERT_EQ(layout.levels.back().width * layout.levels.back().height, 1);
    }
}

// ---- cut_shift, mapped_corners

TextureMapping cut_at(double u, double v) {
  TextureMapping mapping;
  mapping.has_cut = {true, true};
  mapping.cut = {u, v};
  return mapping;
}

TEST(CutShiftTest, WithoutACutNothingMoves) {
  TextureMapping mapping = cut_at(0.3, 0.3);
  mapping.has_cut = {false, false};
  EXPECT_EQ(cut_shift({{5.0f, -7.0f}, {5.5f, -7.0f}, {5.0f, -6.5f}}, {0, 1, 2}, 0, mapping), glm::dvec2(0.0));
}

TEST(CutShiftTest, EveryDirectionIsCutByItself) {
  TextureMapping mapping = cut_at(0.25, 0.25);
  const std::vector<glm::vec2> uvs = {{2.5f, 3.5f}, {2.625f, 3.5f}, {2.5f, 3.625f}};
  EXPECT_EQ(cut_shift(uvs, {0, 1, 2}, 0, mapping), glm::dvec2(-2.0, -3.0));
  mapping.has_cut = {true, false};
  EXPECT_EQ(cut_shift(uvs, {0, 1, 2}, 0, mapping), glm::dvec2(-2.0, 0.0));
  mapping.has_cut = {false, true};
  EXPECT_EQ(cut_shift(uvs, {0, 1, 2}, 0, mapping), glm::dvec2(0.0, -3.0));
}

// All values are multiples of 1/8, which are exact in single and double precision.
TEST(CutShiftTest, TrianglesLandInThePeriodAboveTheCut) {
  for (int eighths = -24; eighths <= 24; ++eighths)
    for (const double cut : {-1.25, 0.0, 0.5, 3.875}) {
      const float u = 0.125f * static_cast<float>(eighths);
      const std::vector<glm::vec2> uvs = {{u, 0.0f}, {u + 0.125f, 0.0f}, {u, 0.125f}};
      const glm::dvec2 shift = cut_shift(uvs, {2, 0, 1}, 0, cut_at(cut, -8.0));
      EXPECT_EQ(shift.x, std::round(shift.x)) << "a whole number of periods";
      EXPECT_GE(static_cast<double>(u) + shift.x, cut);
      EXPECT_LE(static_cast<double>(u) + 0.125 + shift.x, cut + 1.0);
    }
}

// At the seam of a cylinder, a vertex on the cut belongs to the end of one triangle and to the beginning of another.
TEST(CutShiftTest, AVertexOnTheCutGoesWithItsTriangle) {
  const std::vector<glm::vec2> uvs = {{0.25f, 0.0f}, {0.25f, 1.0f}, {0.125f, 0.0f}, {0.375f, 0.0f}};
  TextureMapping mapping = cut_at(0.25, 0.0);
  mapping.has_cut = {true, false};
  const std::vector<glm::vec2> corners = mapped_corners(uvs, {0, 1, 2, 0, 1, 3}, mapping);
  ASSERT_EQ(corners.size(), 6u);
  EXPECT_EQ(corners[0], glm::vec2(1.25f, 0.0f)) << "the triangle left of the cut moves by one period";
  EXPECT_EQ(corners[2], glm::vec2(1.125f, 0.0f));
  EXPECT_EQ(corners[3], glm::vec2(0.25f, 0.0f)) << "the triangle right of the cut stays";
  EXPECT_EQ(corners[5], glm::vec2(0.375f, 0.0f));
}

TEST(CutShiftTest, AcrossTheCutTheMiddleOfTheExtentDecides) {
  TextureMapping mapping = cut_at(1.0, 0.0);
  mapping.has_cut = {true, false};
  // The middle of 0.75 to 1.125 is left of the cut, and the middle of 0.875 to 1.25 is right of it. The means of the
  // vertices are on the opposite sides.
  const std::vector<glm::vec2> left = {{0.75f, 0.0f}, {1.125f, 0.0f}, {1.125f, 1.0f}};
  const std::vector<glm::vec2> right = {{0.875f, 0.0f}, {0.875f, 1.0f}, {1.25f, 0.0f}};
  EXPECT_EQ(cut_shift(left, {0, 1, 2}, 0, mapping).x, 1.0);
  EXPECT_EQ(cut_shift(right, {0, 1, 2}, 0, mapping).x, 0.0);
}

TEST(MappedCornersTest, TheMapIsAppliedAfterTheCut) {
  TextureMapping mapping;
  mapping.linear = glm::dmat2(0.5, 0.25, -2.0, 4.0);  // columns: u goes to (0.5, 0.25), v to (-2, 4)
  mapping.offset = {0.125, -1.0};
  mapping.has_cut = {true, false};
  mapping.cut = {0.5, 0.0};
  const std::vector<glm::vec2> uvs = {{0.0f, 0.0f}, {0.25f, 0.0f}, {0.0f, 0.5f}, {9.0f, 9.0f}};
  const std::vector<glm::vec2> corners = mapped_corners(uvs, {2, 0, 1}, mapping);  // u' = u + 1
  ASSERT_EQ(corners.size(), 3u);
  EXPECT_EQ(corners[0], glm::vec2(0.5f - 1.0f + 0.125f, 0.25f + 2.0f - 1.0f));
  EXPECT_EQ(corners[1], glm::vec2(0.5f + 0.125f, 0.25f - 1.0f));
  EXPECT_EQ(corners[2], glm::vec2(0.625f + 0.125f, 0.3125f - 1.0f));
  EXPECT_TRUE(mapped_corners(uvs, {}, mapping).empty());
}

// ---- JSON

TEST(TextureMappingJsonTest, EveryFieldComesBack) {
  const TextureMapping mapping = unusual_mapping();
  const nlohmann::json json = nlohmann::json::parse(nlohmann::json(mapping).dump());
  EXPECT_EQ(json["linear"], nlohmann::json({1.5, 1.0 / 3.0, -0.25, 1e-9})) << "row by row";
  TextureMapping poisoned;
  poisoned.linear = glm::dmat2(-77.0, -77.0, -77.0, -77.0);
  poisoned.offset = glm::dvec2(-77.0);
  poisoned.has_cut = {!mapping.has_cut[0], !mapping.has_cut[1]};
  poisoned.cut = {-77.0, -77.0};
  poisoned.wrap_s = poisoned.wrap_t = WrapMode::kBlack;
  poisoned.width = poisoned.height = poisoned.stretch_rounds = -77;
  poisoned.stretch_max = -77.0;
  poisoned.visible_pixels = poisoned.degenerate_pixels = 77777;
  json.get_to(poisoned);
  expect_same(poisoned, mapping);
}

TEST(TextureMappingJsonTest, SidesAndWrapModesThatNoTextureHasAreRefused) {
  for (const char* side : {"width", "height"})
    for (const int value : {0, -1, 16385}) {
      nlohmann::json json = unusual_mapping();
      json[side] = value;
      expect_error(ErrorCode::kInput, {std::to_string(value), "expected 1 to 16384 per side"},
                   [&] { json.get<TextureMapping>(); });
      json[side] = value < 1 ? 1 : 16384;
      EXPECT_NO_THROW(json.get<TextureMapping>());
    }
  for (const char* wrap : {"wrapS", "wrapT"})
    for (const char* name : {"black", "mirror", "Clamp", ""}) {
      nlohmann::json json = unusual_mapping();
      json[wrap] = name;
      expect_error(ErrorCode::kInput, {"'" + std::string(name) + "'", "expected clamp or periodic"},
                   [&] { json.get<TextureMapping>(); });
    }
}

}  // namespace
}  // namespace multum
