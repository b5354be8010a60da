// SPDX-License-Identifier: Apache-2.0
// One normal a pixel and frame, drawn from the lobes, as renderers take it that keep one normal: what the mean of
// frames is off by from the sum over lobes, and what one frame is.
#include <gtest/gtest.h>

#include <cstdio>

#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"

namespace multum::gl {
namespace {

/// What the taps of a texture's filter return is averaged before a normal is drawn: one for all of them.
RenderScene one_normal_scene() {
  RenderScene scene = distant_scene();
  scene.filter.shades_taps = false;
  return scene;
}

class DrawnLobeTest : public testing::Test {
 protected:
  void SetUp() override {
    context_ = make_headless_context(test_backend());
    mesh_ = std::make_unique<Mesh>(context_->functions(), make_quad(60.0f));
    renderer_ = std::make_unique<Renderer>(context_->functions(), 80, 60);
  }
  FloatImage sum(const TestMap& map, const RenderScene& scene) {
    const MovmfMaterial material(context_->functions(), map.mipmap, 1.0f, &map.image);
    return renderer_->draw(*mesh_, material, scene).image;
  }
  FloatImage drawn(const TestMap& map, const RenderScene& scene, int frames) {
    MovmfMaterial material(context_->functions(), map.mipmap, 1.0f, &map.image);
    material.set_drawn(true);
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

// Two tilts that average to a broad mean: Toksvig's one lobe is far off, one drawn frame is noise around the truth.
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

// Broad lobes: normals are drawn from within them.
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
