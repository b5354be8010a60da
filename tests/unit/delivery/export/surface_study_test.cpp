// SPDX-License-Identifier: Apache-2.0
// Tests the pictures on the page of an export: textures that are filtered as in hardware, averages compared with the
// covered facets, and videos. A surface with a single normal must look the same with every filter.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <glm/geometric.hpp>

#include "host/delivery/export/accuracy/cell_reference.h"
#include "host/delivery/export/accuracy/export_rules.h"
#include "host/delivery/export/report/frame_video.h"
#include "host/delivery/export/report/level_textures.h"
#include "host/delivery/export/report/surface_frames.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::make_map;
using testing::random_map;

TEST(LevelTexture, IsFilteredAsHardwareDoes) {
  LevelTexture texture(2, 3);
  texture.levels() = {{4, 2, {0, 10, 1, 10, 2, 10, 3, 10, 0, 20, 1, 20, 2, 20, 3, 20}}, {2, 1, {5, 0, 7, 0}}};
  double values[2] = {-1.0, -1.0};
  texture.sample(3.0, 1.5 / 4, 0.5 / 2, values);  // the centre of a texel
  EXPECT_NEAR(values[0], 1.0, 1e-12);
  EXPECT_NEAR(values[1], 10.0, 1e-12);
  texture.sample(3.0, 2.0 / 4, 0.5, values);  // between four texels
  EXPECT_NEAR(values[0], 1.5, 1e-12);
  EXPECT_NEAR(values[1], 15.0, 1e-12);
  texture.sample(3.0, 0.0, 0.25, values);  // across the border, since the texture repeats
  EXPECT_NEAR(values[0], 1.5, 1e-12);
  texture.sample(3.5, 1.5 / 4, 0.25, values);  // halfway to the next level, between 1 and (5 * 0.75 + 7 * 0.25 ...)
  EXPECT_NEAR(values[0], 0.5 * 1.0 + 0.5 * (5.0 * 0.75 + 7.0 * 0.25), 1e-12);
  texture.sample(9.0, 0.25, 0.5, values);  // beyond the coarsest level
  EXPECT_NEAR(values[0], 5.0, 1e-12);
  texture.sample(0.0, -1.0 + 1.5 / 4, 3.25, values);  // beyond the finest level, several repeats away
  EXPECT_NEAR(values[0], 1.0, 1e-12);
}

TEST(AveragedLevels, AreTheMeansOfCoveredFacets) {
  const NormalMap map = random_map(23, 14, 0.9, 4);
  const LevelTexture averages = averaged_levels(planes_of(map), nullptr, 0.0081, 1);
  ASSERT_EQ(averages.channel_count(), 4);
  for (std::size_t l = 0; l < averages.levels().size(); ++l) {
    const auto& level = averages.levels()[l];
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x) {
        const CoveredFacets facets = covered_facets(planes_of(map), nullptr, 0.0081, level.width, level.height, x, y);
        const float* const texel = &level.texels[size_of(y * level.width + x) * 4];
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(texel[c], facets.mean_normal[c], 1e-5) << l << " " << x << " " << y;
        ASSERT_NEAR(texel[3], 0.3, 1e-5);
      }
  }
}

// A tilted plane has the same normal everywhere. All averages equal that normal, and no rule makes the surface rougher.
TEST(SurfaceFrames, AllAreAlikeWhereThereIsOneNormal) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.2, -0.1, 1.0));
  const NormalMap map = make_map(40, 24, [&](int, int) { return normal; });
  const double alpha = 0.09;
  const LevelTexture averages = averaged_levels(planes_of(map), nullptr, alpha * alpha, 2);
  SurfaceModel rule{"averaged", "averaged", SurfaceModel::Kind::kOneLobe, averages};
  SurfaceModel baked{"baked", "baked", SurfaceModel::Kind::kBakedLobes, LevelTexture(8, 2)};
  for (const TextureLevel& level : averages.levels()) {
    TextureLevel lobes{level.width, level.height, {}};
    for (int i = 0; i < level.width * level.height; ++i)
      for (const double share : {0.75, 0.25})
        for (const double value : {normal.x, normal.y, normal.z, 1.0})
          lobes.texels.push_back(static_cast<float>(share * value));
    baked.texture.levels().push_back(std::move(lobes));
  }
  for (const double level : {2.0, 3.3, 5.0}) {
    const FrameView view{level, {20.0, 12.0}, {0.1, 0.05}};
    const FramePixels reference = draw_reference(planes_of(map), nullptr, alpha * alpha, view, 2);
    const FramePixels averaged = draw_model(rule, averages, view, 40, 24, 2);
    const FramePixels of_lobes = draw_model(baked, averages, view, 40, 24, 1);
    double total = 0.0, off = 0.0, off_of_lobes = 0.0;
    for (std::size_t i = 0; i < reference.size(); ++i) {
      total += reference[i];
      off += std::abs(averaged[i] - reference[i]);
      off_of_lobes += std::abs(of_lobes[i] - reference[i]);
    }
    EXPECT_GT(total, 100.0);
    EXPECT_LT(off / total, 1e-4) << level;
    EXPECT_LT(off_of_lobes / total, 0.02) << level;  // GGX over a lobe is a fit, even over one normal
  }
}

// A near pixel shows one texel, and its reference is the facet of that texel. A far pixel shows the mean of all facets.
TEST(SurfaceFrames, TheReferenceIsTheMeanOfFacets) {
  const NormalMap map = random_map(16, 16, 0.9, 8);
  const FrameView view{2.0, {192.0, 192.0}, {0.0, 0.0}};  // pixel (0, 0) begins at texel (0, 0)
  const FramePixels pixels = draw_reference(planes_of(map), nullptr, 0.01, view, 2);
  const CoveredFacets facets = covered_facets(planes_of(map), nullptr, 0.01, 4, 4, 1, 2);
  // Tests the light of pixel (1, 2) in the picture. Half vectors are spread evenly over slopes, and the eye is 30
  // degrees above the horizon.
  const double step = 2.0 * 0.45 / kFrameSide;
  const glm::dvec3 eye(0.0, 0.5, std::sqrt(0.75));
  const glm::dvec3 half = glm::normalize(glm::dvec3(-0.45 + 1.5 * step, 0.45 - 2.5 * step, 1.0));
  LightSet light;
  light.view = eye;
  light.add(2.0 * glm::dot(eye, half) * half - eye);
  double expected = 0.0, density = 0.0;
  for (std::size_t i = 0; i < facets.normals.size(); ++i)
    add_highlights(light, facets.normals[i], facets.alpha_squared[i], facets.weights[i], &expected, &density);
  EXPECT_NEAR(pixels[2 * size_of(kFrameSide) + 1], expected, 1e-5 * (1.0 + expected));
}

class FrameVideoTest : public ::testing::Test {
 protected:
  static VideoFrames frames() {
    VideoFrames video;
    video.width = video.height = 32;
    for (int f = 0; f < 6; ++f) video.frames.emplace_back(32 * 32, static_cast<std::uint8_t>(40 * f));
    return video;
  }
};

TEST_F(FrameVideoTest, IsAWebM) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "ffmpeg is not installed (Debian package ffmpeg)";
  const std::string bytes = encode_webm(frames(), std::filesystem::temp_directory_path().string());
  EXPECT_EQ(bytes.substr(0, 4), "\x1a\x45\xdf\xa3");
  EXPECT_NE(bytes.find("webm"), std::string::npos);
  EXPECT_NE(bytes.find("V_VP9"), std::string::npos);
}

TEST_F(FrameVideoTest, SaysThatThereIsNoFfmpeg) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  std::string what;
  try {
    encode_webm(frames(), std::filesystem::temp_directory_path().string());
  } catch (const Error& error) {
    what = error.what();
    EXPECT_EQ(error.code(), ErrorCode::kEnvironment);
  }
  setenv("PATH", path.c_str(), 1);
  EXPECT_NE(what.find("ffmpeg"), std::string::npos) << what;
  EXPECT_NE(what.find("package"), std::string::npos) << what;
}

}  // namespace
}  // namespace multum
