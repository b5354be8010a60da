// SPDX-License-Identifier: Apache-2.0
// Tests forward mapping, the baseline of texture inference.
#include "host/fields/inference/mapping/forward_mapping.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include "host/formats/asset/mip_layout.h"

namespace multum {
namespace {

constexpr int kSide = 64;

// Holds the unit square with positions as texture coordinates. It fills a picture of kSide pixels except for `left`,
// which is cut off.
struct Square {
  ObjectMesh mesh;
  ItemBuffer items;
  glm::dmat4 object_to_clip;
  TextureMapping mapping;
  ObjectLayer layer;

  explicit Square(int texels, const std::function<float(double u, double v)>& value, int left = 0) {
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh.indices = {0, 1, 2, 0, 2, 3};
    const glm::dmat4 projection = glm::perspective(2.0 * std::atan(0.5), 1.0, 0.1, 10.0);
    const glm::dmat4 to_camera = glm::translate(glm::dmat4(1.0), glm::dvec3(-0.5, -0.5, -1.0));
    object_to_clip = projection * to_camera;
    items = draw_item_buffer({{&mesh, to_camera}}, projection, kSide, kSide);
    mapping.width = mapping.height = texels;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        layer.coverage.push_back(x < left ? 0.0f : 1.0f);
        for (int c = 0; c < 3; ++c)
          layer.rgb.push_back(value((x + 0.5) / kSide, 1.0 - (y + 0.5) / kSide) * static_cast<float>(c + 1));
      }
  }
  std::vector<float> texels() const { return forward_mapped(mesh, mapping, {{object_to_clip, &items, 0, &layer}}); }
};

// The pixel centres are at texel centres, so every texel equals its pixel. Row 0 is at the top.
TEST(ForwardMappingTest, PixelsOnTexelsAreKept) {
  const Square square(kSide, [](double u, double v) { return static_cast<float>(0.1 + 0.5 * u + 0.2 * v * v); });
  const std::vector<float> texels = square.texels();
  for (std::size_t i = 0; i < square.layer.rgb.size(); ++i) ASSERT_NEAR(texels[i], square.layer.rgb[i], 1e-4f) << i;
}

TEST(ForwardMappingTest, CoarseLevelsAreBoxes) {
  const Square square(kSide, [](double u, double) { return static_cast<float>(u); });
  const std::vector<float> texels = square.texels();
  const MipLayout layout(kSide, kSide);
  const float expected = 0.25f * (texels[0] + texels[3] + texels[3 * kSide] + texels[3 * kSide + 3]);
  EXPECT_NEAR(texels[static_cast<std::size_t>(3 * layout.levels[1].offset)], expected, 1e-6f);
  EXPECT_NEAR(texels[static_cast<std::size_t>(3 * (layout.texel_count - 1))], 0.5f, 1e-3f);
}

// Texels that no pixel reached are filled smoothly from their neighbours.
TEST(ForwardMappingTest, HolesAreFilled) {
  const Square square(
      40, [](double, double) { return 0.3f; }, kSide / 2);
  const std::vector<float> texels = square.texels();
  for (std::size_t i = 0; i < texels.size(); i += 3) ASSERT_NEAR(texels[i], 0.3f, 1e-5f) << i;
}

}  // namespace
}  // namespace multum
