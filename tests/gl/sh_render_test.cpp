// SPDX-License-Identifier: Apache-2.0
// Draws spherical harmonics in both contexts. Compares the pictures with the reference, with lobes, and with each
// other. Also tests GL errors, the uploaded layers of a texture array, levels that come from the normal map, and black
// borders.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include <glm/geometric.hpp>

#include "host/foundation/base/error.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tests/gl/sh_test_map.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"

namespace multum::gl {
namespace {

constexpr int kShWidth = 96, kShHeight = 72;

RenderScene scene_of(float exponent, float uv_scale = 60.0f) {
  RenderScene scene;  // so far away that a pixel covers several texels, of which there are 32 per unit
  scene.camera.eye = {0.0f, -8.0f, 12.0f};
  scene.camera.target = {0.0f, 8.0f, 0.0f};
  scene.uv_scale = uv_scale;
  scene.brdf.exponent = exponent;
  scene.lights = {{glm::normalize(glm::vec3(0.0f, 1.0f, 0.6f)), glm::vec3(3.0f)},
                  {glm::normalize(glm::vec3(-0.4f, 0.5f, 1.0f)), glm::vec3(1.0f)}};
  return scene;
}

class ShRenderTest : public testing::TestWithParam<ContextBackend> {
 protected:
  void SetUp() override {
    context_ = make_test_context(GetParam());
    mesh_ = std::make_unique<Mesh>(context_->functions(), make_quad(60.0f));
    renderer_ = std::make_unique<Renderer>(context_->functions(), kShWidth, kShHeight);
  }
  void TearDown() override {
    if (context_ != nullptr) {
      EXPECT_NO_THROW(check_gl(context_->functions(), "end of the test"));
    }
  }
  FloatImage draw(const ShMipmap& mipmap, const RenderScene& scene, const NormalImage* source = nullptr,
                  ShCosine cosine = ShCosine::kIrradiance) {
    ShMaterial material(context_->functions(), mipmap, 1.0f, source);
    material.set_cosine(cosine);
    return renderer_->draw(*mesh_, material, scene).image;
  }
  FloatImage reference(const TestMap& map, const RenderScene& scene, int samples) {
    const NormalMaterial material(context_->functions(), map.image, NormalMaterial::Sampling::kNearest, 1.0f);
    return renderer_->draw_reference(*mesh_, material, scene, {samples}).image;
  }
  FloatImage lobes(const TestMap& map, const RenderScene& scene) {
    return renderer_->draw(*mesh_, MovmfMaterial(context_->functions(), map.mipmap, 1.0f), scene).image;
  }
  double error(const FloatImage& drawn, const FloatImage& exact) { return picture_error(drawn, exact).relative_l1; }

  std::unique_ptr<HeadlessContext> context_;
  std::unique_ptr<Mesh> mesh_;
  std::unique_ptr<Renderer> renderer_;
};

INSTANTIATE_TEST_SUITE_P(Contexts, ShRenderTest, testing::ValuesIn(test_backends()), [](const auto& backend) {
  return backend.param == ContextBackend::kOsmesa ? "Osmesa" : "Egl";
});

// If highlights are as broad as the order allows, each higher order has a lower error. Sharp highlights are blurred,
// and a warning says so.
TEST_P(ShRenderTest, OrdersDrawWhatTheyHave) {
  const TestMap map = make_two_tilt_map(32, 25.0, StorageEncoding::kFloat, false);
  const RenderScene broad = scene_of(10.0f), sharp = scene_of(200.0f);
  const FloatImage exact = reference(map, broad, 256), exact_sharp = reference(map, sharp, 256);
  const auto at = [&](int order, const RenderScene& scene, const FloatImage& expected) {
    return error(draw(make_harmonics(map.image, order, StorageEncoding::kFloat), scene), expected);
  };
  EXPECT_GT(at(2, broad, exact), at(4, broad, exact));
  EXPECT_GT(at(4, broad, exact), at(8, broad, exact));
  EXPECT_LT(at(8, broad, exact), 0.08);
  EXPECT_GT(at(8, sharp, exact_sharp), at(8, broad, exact));
}

TEST_P(ShRenderTest, HalfsAreAsGoodAsFloats) {
  const TestMap map = make_noise_map(32, 1.0f, WrapMode::kPeriodic);
  const RenderScene scene = scene_of(20.0f);
  const FloatImage exact = draw(make_harmonics(map.image, 8, StorageEncoding::kFloat), scene);
  EXPECT_LT(error(draw(make_harmonics(map.image, 8, StorageEncoding::kHalf), scene), exact), 2e-3);
}

// Each level has only one normal, so that all cosines of the highlight are equal.
TEST_P(ShRenderTest, AFlatMapIsItsBrdfCutOff) {
  const TestMap map = make_flat_map(8);
  const RenderScene scene = scene_of(10.0f);
  const ShMipmap harmonics = make_harmonics(map.image, 8, StorageEncoding::kFloat);
  EXPECT_LT(error(draw(harmonics, scene), lobes(map, scene)), 0.02);
  EXPECT_LT(error(draw(harmonics, scene, nullptr, ShCosine::kMeanNormal),
                  draw(harmonics, scene, nullptr, ShCosine::kMeanDirection)),
            1e-5);
}

// Levels finer than the first stored one come from the normal map, as one lobe. A near view shows only these levels,
// and its pixels show the normals between texels.
TEST_P(ShRenderTest, LevelsThatAreLeftToTheNormalMap) {
  const TestMap map = make_noise_map(16, 1.0f, WrapMode::kPeriodic);
  const ShMipmap whole = make_harmonics(map.image, 4, StorageEncoding::kFloat);
  ShMipmap coarse = whole;
  coarse.header.first_level = 2;
  for (std::size_t l = 0; l < 2; ++l) coarse.levels[l].parts.clear();
  const RenderScene far = scene_of(20.0f, 600.0f);
  RenderScene near = scene_of(20.0f);
  look_from_above(near, 2.05, 16, kShHeight);
  EXPECT_LT(error(draw(coarse, far, &map.image), draw(whole, far)), 1e-5);
  TestMap one_lobe = make_one_lobe_map(map.image);
  EXPECT_LT(error(draw(coarse, near, &map.image), lobes(one_lobe, near)), 1e-4);
  EXPECT_THROW(ShMaterial(context_->functions(), coarse, 1.0f, nullptr), Error);
  ShMipmap cut = whole;
  cut.levels[1].parts[3].pop_back();
  EXPECT_THROW(ShMaterial(context_->functions(), cut, 1.0f), Error);
}

TEST_P(ShRenderTest, BeyondABlackBorderThereIsNothing) {
  const auto lit = [&](WrapMode wrap) {
    TestMap map = make_flat_map(8);
    map.image.wrap_s = map.image.wrap_t = wrap;
    // The plane shows two repeats of the map. The left part of the plane's far half, some rows below the horizon, is
    // within the map.
    const FloatImage drawn = draw(make_harmonics(map.image, 4, StorageEncoding::kFloat), scene_of(10.0f, 2.0f));
    std::size_t count = 0;
    for (std::size_t i = 0; i < drawn.rgba.size(); i += 4) count += drawn.rgba[i] > 0.0f ? 1 : 0;
    return count;
  };
  const std::size_t everywhere = lit(WrapMode::kPeriodic), within = lit(WrapMode::kBlack);
  EXPECT_GT(within, 20u);
  EXPECT_LT(within, everywhere / 4);
}

// Both contexts are llvmpipe on most machines, which takes ten seconds for the longest shader. Hence only one context
// draws it.
TEST_P(ShRenderTest, OrdersFromTheLeastToTheMost) {
  const int high = GetParam() == ContextBackend::kOsmesa ? 20 : 8;
  const TestMap map = make_two_tilt_map(8, 25.0, StorageEncoding::kFloat, false);
  const RenderScene scene = scene_of(5.0f);
  const FloatImage exact = lobes(map, scene);
  const double least = error(draw(make_harmonics(map.image, 1, StorageEncoding::kHalf), scene), exact);
  const double most = error(draw(make_harmonics(map.image, high, StorageEncoding::kHalf), scene), exact);
  EXPECT_LT(most, 0.03);
  EXPECT_GT(least, most);
}

// Diffuse light up to l = 2 depends only on E[n] and E[n n^T]. Lobes that hold a single direction are also exact there.
// If normals are tilted by 60 degrees to both sides, a single lobe around the mean normal has a large error.
TEST_P(ShRenderTest, DiffuseLightFromEverywhereIsThatOfLobes) {
  EnvironmentMap sky{32, 16, {}};
  for (int y = 0; y < sky.height; ++y)
    for (int x = 0; x < sky.width; ++x) {
      const glm::dvec3 d = environment_direction((x + 0.5) / sky.width, (y + 0.5) / sky.height);
      sky.texels.emplace_back(glm::dvec3(0.2, 0.3, 0.4) + std::max(0.0, d.x) * glm::dvec3(2.0, 1.0, 0.5) +
                              std::max(0.0, d.y) * glm::dvec3(0.2, 0.5, 1.0));
    }
  const TestMap map = make_two_tilt_map(16, 60.0, StorageEncoding::kFloat, false);
  RenderScene scene = scene_of(10.0f);
  scene.lights.clear();
  scene.environment = make_environment_light(sky);
  scene.brdf.kind = BrdfKind::kLambert;
  const FloatImage exact = lobes(map, scene);
  for (const int order : {2, 4})
    EXPECT_LT(error(draw(make_harmonics(map.image, order, StorageEncoding::kFloat), scene), exact), 1e-3) << order;
  EXPECT_GT(error(draw(make_harmonics(map.image, 1, StorageEncoding::kFloat), scene), exact), 0.01);
}

// Lobes use the mean cosine of the normals that the light reaches (movmf_shading.glsl). The error with this cosine is
// at most as large as the error with the other cosines.
TEST_P(ShRenderTest, TheHighlightsCosineIsTheNearest) {
  const TestMap map = make_noise_map(64, 1.5f, WrapMode::kPeriodic);
  const ShMipmap harmonics = make_harmonics(map.image, 8, StorageEncoding::kFloat);
  const RenderScene scene = scene_of(10.0f);
  const FloatImage exact = reference(map, scene, 256);
  const double chosen = error(draw(harmonics, scene), exact);
  for (const ShCosine other : {ShCosine::kMeanNormal, ShCosine::kMeanDirection}) {
    const double found = error(draw(harmonics, scene, nullptr, other), exact);
    RecordProperty(other == ShCosine::kMeanNormal ? "mean_normal" : "mean_direction", std::to_string(found));
    EXPECT_LE(chosen, found + 0.005);
  }
  RecordProperty("irradiance", std::to_string(chosen));
}

}  // namespace
}  // namespace multum::gl
