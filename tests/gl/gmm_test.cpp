// SPDX-License-Identifier: Apache-2.0
// Draws planar Gaussians in both contexts, and compares the pictures with the reference in cases where the model is
// exact or almost exact.
#include <gtest/gtest.h>

#include <memory>

#include "host/foundation/base/error.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/materials/gmm_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"

namespace multum::gl {
namespace {

constexpr int kGmmWidth = 96, kGmmHeight = 72;

class GmmTest : public testing::TestWithParam<ContextBackend> {
 protected:
  void SetUp() override {
    context_ = make_test_context(GetParam());
    mesh_ = std::make_unique<Mesh>(context_->functions(), make_quad(60.0f));
    renderer_ = std::make_unique<Renderer>(context_->functions(), kGmmWidth, kGmmHeight);
  }
  void TearDown() override {
    if (context_ == nullptr) return;  // no context could be made
    EXPECT_NO_THROW(check_gl(context_->functions(), "end of the test"));
  }
  FloatImage gaussians(const TestMap& map, const RenderScene& scene, int first_level = 0) {
    MovmfMipmap mipmap = as_gaussians(map.mipmap);
    drop_finer_levels(mipmap, first_level);
    return renderer_->draw(*mesh_, *make_lobe_material(context_->functions(), mipmap, 1.0f, &map.image), scene).image;
  }
  FloatImage lobes(const TestMap& map, const RenderScene& scene) {
    return renderer_->draw(*mesh_, *make_lobe_material(context_->functions(), map.mipmap, 1.0f), scene).image;
  }
  FloatImage reference(const TestMap& map, const RenderScene& scene, int samples) {
    const NormalMaterial material(context_->functions(), map.image, NormalMaterial::Sampling::kNearest, 1.0f);
    return renderer_->draw_reference(*mesh_, material, scene, {samples}).image;
  }
  std::unique_ptr<HeadlessContext> context_;
  std::unique_ptr<Mesh> mesh_;
  std::unique_ptr<Renderer> renderer_;
};

INSTANTIATE_TEST_SUITE_P(Backends, GmmTest, testing::ValuesIn(test_backends()),
                         [](const auto& test) { return std::string(context_backend_name(test.param)); });

// All normals are upright, so only the shape of the Gaussian differs from Blinn-Phong: by 6 % at s = 20 and by 1 % at s
// = 100.
TEST_P(GmmTest, AFlatMapIsNearTheReference) {
  const TestMap map = make_flat_map(16);
  RenderScene scene;
  scene.uv_scale = 60.0f;
  scene.lights = {{{0.0f, 1.0f, 0.4f}, glm::vec3(3.0f)}, {{-0.4f, 0.5f, 1.0f}, glm::vec3(1.0f)}};
  for (const auto& [exponent, bound] : {std::pair{20.0f, 0.06}, {100.0f, 0.02}, {500.0f, 0.02}}) {
    scene.brdf.exponent = exponent;
    EXPECT_LT(picture_error(gaussians(map, scene), reference(map, scene, 16)).relative_l1, bound) << exponent;
  }
}

// Two tilts of 25 degrees with equal shares give two Gaussians, but averaged normals give only one. Facets are
// foreshortened.
TEST_P(GmmTest, TwoTiltsAreNearTheReference) {
  for (const StorageEncoding encoding : {StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat}) {
    const TestMap map = make_two_tilt_map(64, 25.0, encoding, true);
    const RenderScene scene = distant_scene();
    EXPECT_LT(picture_error(gaussians(map, scene), reference(map, scene, 512)).relative_l1, 0.05);
  }
}

// Compares pictures of Gaussians with pictures of lobes and with the reference, for BRDFs with Fresnel and shadowing,
// and for Lambert's BRDF without a highlight. With 512 samples per pixel, the reference's noise is 0.4 % (Lambert's
// error). A Gaussian is not exactly the shape of Torrance and Sparrow's facets, which causes an error of 2.1 %, even on
// a flat map (AFlatMapIsNearTheReference).
TEST_P(GmmTest, OtherBrdfsAreNearLobesAndTheReference) {
  const TestMap map = make_two_tilt_map(16, 15.0, StorageEncoding::kFloat, false);
  RenderScene scene = distant_scene();
  for (const auto& [kind, bound] :
       {std::pair{BrdfKind::kLambert, 0.01}, {BrdfKind::kTorranceSparrow, 0.03}, {BrdfKind::kCookTorrance, 0.01}}) {
    scene.brdf.kind = kind;
    scene.brdf.sigma = 0.1f;
    const FloatImage found = gaussians(map, scene);
    EXPECT_LT(picture_error(found, lobes(map, scene)).relative_l1, 0.06) << static_cast<int>(kind);
    EXPECT_LT(picture_error(found, reference(map, scene, 512)).relative_l1, bound) << static_cast<int>(kind);
  }
  // Most of the light is diffuse. Without diffuse light, the error of the highlight is 3.8 %.
  scene.brdf.diffuse = glm::vec3(0.0f);
  scene.brdf.f0 = glm::vec3(0.3f);
  EXPECT_LT(picture_error(gaussians(map, scene), reference(map, scene, 512)).relative_l1, 0.06);
}

// Levels finer than the first stored level come from the normal map. The other levels do not change.
TEST_P(GmmTest, FilesThatBeginAtACoarserLevel) {
  const TestMap map = make_two_tilt_map(64, 20.0, StorageEncoding::kFloat, true);
  RenderScene far = distant_scene();
  far.uv_scale = 240.0f;
  EXPECT_LT(picture_error(gaussians(map, far, 1), gaussians(map, far)).relative_l1, 1e-5);
  const TestMap wave = make_wave_map(64, WrapMode::kPeriodic);
  RenderScene near = distant_scene();
  near.uv_scale = 0.5f;  // the map is magnified, so pixels show single normals
  EXPECT_LT(picture_error(gaussians(wave, near, 1), gaussians(wave, near)).relative_l1, 0.02);
}

}  // namespace
}  // namespace multum::gl
