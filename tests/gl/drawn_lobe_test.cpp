// SPDX-License-Identifier: Apache-2.0
// Tests drawing one random normal per pixel and frame from the lobes, for renderers that keep only one normal. Compares
// the mean over frames with the sum over lobes, and checks a single frame.
#include <gtest/gtest.h>

#include <cstdio>

#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"

namespace multum::gl {
namespace {

/// Returns a scene that draws one normal per pixel. The taps of the texture filter are averaged before the normal is
/// drawn.
RenderScene one_normal_scene() {
  RenderScene scene = distant_scene();
  scene.filter.shades_taps = false;
  return scene;
}

class DrawnLobeTest : public testing::Test {
 protected:
  void SetUp() override {
    context_ = make_test_context(test_backend());
    mesh_ = std::make_unique<Mesh>(context_->functions(), make_quad(60.0f));
    renderer_ = std::make_unique<Renderer>(context_->functions(), 80, 60);
  }
  FloatImage sum(const TestMap& map, const RenderScene& scene) {
    const MovmfMaterial material(context_->functions(), map.mipmap, 1.0f, &map.image);
    return renderer_->draw(*mesh_, material, scene).image;
  }
  FloatImage drawn(const TestMap& map, const RenderScene& scene, int frames, DrawnNoise noise = DrawnNoise::kBlue) {
    MovmfMaterial material(context_->functions(), map.mipmap, 1.0f, &map.image);
    material.set_drawn(context_->functions(), noise);
    return renderer_->draw_reference(*mesh_, material, scene, {frames}).image;
  }
  FloatImage toksvig(const TestMap& map, const RenderScene& scene) {
    NormalMaterial material(context_->functions(), map.image, NormalMaterial::Sampling::kMipmapped, 1.0f);
    material.set_baseline(Baseline::kToksvig);
    return renderer_->draw(*mesh_, material, scene).image;
  }
  std::unique_ptr<HeadlessContext> context_;
  std::unique_ptr<Mesh> mesh_;
  std::unique_ptr<Renderer> renderer_;
};

// Averaging two tilts gives one broad lobe. Toksvig's rule shades only this lobe, so its error is large. A frame of
// drawn normals has no such error, only noise around the sum over the lobes.
TEST_F(DrawnLobeTest, TheMeanOfFramesIsTheSum) {
  const TestMap map = make_two_tilt_map(64, 20.0, StorageEncoding::kFloat, false);
  RenderScene scene = one_normal_scene();
  scene.brdf.exponent = 50.0f;
  scene.brdf.diffuse = glm::vec3(0.0f);
  scene.brdf.specular = glm::vec3(1.0f);
  const FloatImage exact = sum(map, scene);
  const auto off = [&](const FloatImage& image) { return picture_error(image, exact).relative_l1; };
  const double one = off(drawn(map, scene, 1)), sixteen = off(drawn(map, scene, 16)),
               all = off(drawn(map, scene, 1024));
  const double one_lobe = off(toksvig(map, scene));
  std::printf("relative L1 of drawn normals: 1 frame %.3f, mean of 16 %.3f, of 1024 %.4f; Toksvig %.3f\n", one, sixteen,
              all, one_lobe);
  EXPECT_LT(all, 0.01);
  EXPECT_LT(sixteen, 0.5 * one);
  EXPECT_LT(sixteen, one_lobe);
}

/// Blurs with the weights 1 4 6 4 1 along each axis and drops the border, like a simple denoiser or an eye that is
/// farther away.
FloatImage blurred(const FloatImage& image) {
  constexpr int kWeights[] = {1, 4, 6, 4, 1};
  FloatImage result{image.width - 4, image.height - 4, {}};
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x)
      for (int c = 0; c < 4; ++c) {
        double sum = 0.0;
        for (int j = 0; j < 5; ++j)
          for (int i = 0; i < 5; ++i)
            sum += kWeights[i] * kWeights[j] / 256.0 *
                   static_cast<double>(image.rgba[static_cast<std::size_t>(((y + j) * image.width + x + i) * 4 + c)]);
        result.rgba.push_back(static_cast<float>(sum));
      }
  return result;
}

// Compares blue noise with white noise (a hash of the pixel). Single pixels have the same error with both; averages
// over neighbours have a lower error with blue noise. The bounds are in docs/contributing/ALGORITHMS.md.
TEST_F(DrawnLobeTest, BlueNoiseIsNearerOnceBlurred) {
  struct Map {
    const char* name;
    TestMap map;
    double of_one, of_sixteen;  // the largest error of a blurred picture, as a fraction of the error with the hash
    double sixteen;             // the relative L1 error of the mean of 16 frames, which are not blurred
  };
  const Map maps[] = {{"two tilts", make_two_tilt_map(64, 20.0, StorageEncoding::kFloat, false), 0.3, 0.4, 0.06},
                      {"broad lobes", make_noise_map(64, 0.5f, WrapMode::kPeriodic), 0.65, 0.7, 0.18}};
  for (const auto& [name, map, of_one, of_sixteen, sixteen] : maps) {
    RenderScene scene = one_normal_scene();
    scene.brdf.exponent = 50.0f;
    scene.brdf.diffuse = glm::vec3(0.0f);
    scene.brdf.specular = glm::vec3(1.0f);
    const FloatImage exact = sum(map, scene), exact_blurred = blurred(exact);
    for (const int frames : {1, 16}) {
      double plain[2], soft[2];
      for (const DrawnNoise noise : {DrawnNoise::kWhite, DrawnNoise::kBlue}) {
        const FloatImage image = drawn(map, scene, frames, noise);
        const std::size_t i = noise == DrawnNoise::kBlue ? 1 : 0;
        plain[i] = picture_error(image, exact).relative_l1;
        soft[i] = picture_error(blurred(image), exact_blurred).relative_l1;
      }
      std::printf("%s, frames %d: error of white noise %.3f, blurred %.3f; of blue noise %.3f, blurred %.3f\n", name,
                  frames, plain[0], soft[0], plain[1], soft[1]);
      EXPECT_LT(soft[1], (frames == 1 ? of_one : of_sixteen) * soft[0]) << name << ", frames " << frames;
      if (frames == 16) EXPECT_LT(plain[1], sixteen) << name;
      else EXPECT_NEAR(plain[1], plain[0], 0.02 * plain[0]) << name;
    }
  }
}

// If lobes are broad, normals must be drawn from the whole lobe and not only from its mean direction.
TEST_F(DrawnLobeTest, TheMeanOfBroadLobesIsTheSum) {
  const TestMap map = make_noise_map(64, 0.5f, WrapMode::kPeriodic);
  RenderScene scene = one_normal_scene();
  scene.brdf.exponent = 30.0f;
  const FloatImage exact = sum(map, scene);
  const double all = picture_error(drawn(map, scene, 1024), exact).relative_l1;
  std::printf("broad lobes, relative L1 of 1024 frames: %.4f\n", all);
  EXPECT_LT(all, 0.01);
}

}  // namespace
}  // namespace multum::gl
