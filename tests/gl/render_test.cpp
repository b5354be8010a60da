// SPDX-License-Identifier: Apache-2.0
// Draws maps whose mixtures are exact. With both back-ends, the picture of the baked map must equal the reference
// picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/split_mix.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/contact_sheet.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"

namespace multum::gl {
namespace {

constexpr int kRenderWidth = 80;
constexpr int kRenderHeight = 60;

class RenderTest : public testing::TestWithParam<ContextBackend> {
 protected:
  void SetUp() override {
    context_ = make_test_context(GetParam());
    mesh_ = std::make_unique<Mesh>(context_->functions(), make_quad(60.0f));
    renderer_ = std::make_unique<Renderer>(context_->functions(), kRenderWidth, kRenderHeight);
  }
  void TearDown() override {
    if (context_ == nullptr) return;
    EXPECT_NO_THROW(check_gl(context_->functions(), "end of the test"));
  }
  FloatImage movmf(const TestMap& map, const RenderScene& scene, LobeFormula formula = LobeFormula::kProduct) {
    MovmfMaterial material(context_->functions(), map.mipmap, 1.0f, &map.image);
    material.set_formula(formula);
    return renderer_->draw(*mesh_, material, scene).image;
  }
  /// Draws the lobes from a file that begins at `first_level`.
  FloatImage movmf_from(int first_level, TestMap map, const RenderScene& scene,
                        LobeFormula formula = LobeFormula::kProduct) {
    drop_finer_levels(map.mipmap, first_level);
    return movmf(map, scene, formula);
  }
  FloatImage reference(const TestMap& map, const RenderScene& scene, int samples) {
    const NormalMaterial material(context_->functions(), map.image, NormalMaterial::Sampling::kNearest, 1.0f);
    return renderer_->draw_reference(*mesh_, material, scene, {samples}).image;
  }
  FloatImage moments(const TestMap& map, const MomentMipmap& mipmap, const RenderScene& scene, MomentShading shading) {
    MomentMaterial material(context_->functions(), mipmap, 1.0f, &map.image);
    material.set_shading(shading);
    return renderer_->draw(*mesh_, material, scene).image;
  }
  FloatImage baseline(const TestMap& map, const RenderScene& scene, Baseline which) {
    NormalMaterial material(context_->functions(), map.image, NormalMaterial::Sampling::kMipmapped, 1.0f);
    material.set_baseline(which);
    return renderer_->draw(*mesh_, material, scene).image;
  }
  std::unique_ptr<HeadlessContext> context_;
  std::unique_ptr<Mesh> mesh_;
  std::unique_ptr<Renderer> renderer_;
};

std::shared_ptr<RoughnessMap> roughness_map(int size, const std::function<float(int x, int y)>& value) {
  auto map = std::make_shared<RoughnessMap>();
  *map = {size, size, {}, WrapMode::kPeriodic, WrapMode::kPeriodic};
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) map->texels.push_back(value(x, y));
  return map;
}

Brdf metal(float roughness) {
  Brdf brdf;
  brdf.kind = BrdfKind::kGgx;
  brdf.roughness = roughness;
  brdf.f0 = brdf.specular = glm::vec3(1.0f);
  brdf.diffuse = glm::vec3(0.0f);
  return brdf;
}

// The roughness is the factor times the texture value, as in glTF.
TEST_P(RenderTest, ARoughnessTextureMultipliesTheBrdfs) {
  const TestMap map = make_two_tilt_map(16, 20.0, StorageEncoding::kFloat, false);
  RenderScene scene = distant_scene();
  scene.brdf = metal(0.4f);
  const FloatImage plain = movmf(map, scene);
  scene.brdf.roughness = 0.8f;
  scene.roughness = roughness_map(16, [](int, int) { return 0.5f; });
  EXPECT_LT(picture_error(movmf(map, scene), plain).relative_l1, 1e-5);
  scene.roughness = roughness_map(16, [](int, int) { return 1.0f; });
  EXPECT_GT(picture_error(movmf(map, scene), plain).relative_l1, 0.2);
}

// One half of the map is twice as rough as the other half. Each half is shaded with its own roughness, near and far.
TEST_P(RenderTest, ARoughnessTextureEqualsTheReference) {
  const TestMap map = make_two_tilt_map(64, 20.0, StorageEncoding::kFloat, false);
  RenderScene scene = distant_scene();
  scene.brdf = metal(1.0f);
  const auto halves = [](int x, int) { return x < 32 ? 0.35f : 0.7f; };
  scene.roughness = roughness_map(64, halves);
  const FloatImage exact = reference(map, scene, 1024);
  const double own = picture_error(movmf(map, scene), exact).relative_l1;
  scene.roughness = nullptr;
  scene.brdf.roughness = 0.525f;
  const double mean = picture_error(movmf(map, scene), exact).relative_l1;
  std::printf("relative L1 with the texture %.3f, with its mean %.3f\n", own, mean);
  EXPECT_LT(own, 0.15);  // pixels that see both halves have their mean roughness
  EXPECT_LT(own, 0.3 * mean);
}

TEST_P(RenderTest, FlatMapEqualsReferenceFromNearAndFar) {
  const TestMap map = make_flat_map(16);
  for (const float exponent : {5.0f, 100.0f, 5000.0f}) {
    RenderScene scene;  // the default view reaches from a magnified foreground to the far distance
    scene.uv_scale = 60.0f;
    scene.brdf.exponent = exponent;
    scene.lights = {{{0.0f, 1.0f, 0.4f}, glm::vec3(3.0f)}, {{-0.4f, 0.5f, 1.0f}, glm::vec3(1.0f)}};
    const FloatImage drawn = movmf(map, scene);
    EXPECT_LT(picture_error(drawn, baseline(map, scene, Baseline::kMip)).relative_l1, 1e-4) << exponent;
    EXPECT_LT(picture_error(drawn, baseline(map, scene, Baseline::kToksvig)).relative_l1, 1e-4) << exponent;
    // At s = 5000 a pixel of this small picture is as wide as the highlight. The reference averages the highlight over
    // the pixel; no filter of normals does.
    const double bound = exponent < 1000.0f ? 0.005 : 0.05;
    EXPECT_LT(picture_error(drawn, reference(map, scene, 16)).relative_l1, bound) << exponent;
  }
}

TEST_P(RenderTest, TwoTiltsEqualReferenceWhereMipsFail) {
  for (const StorageEncoding encoding : {StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat}) {
    const TestMap map = make_two_tilt_map(64, 25.0, encoding, false);
    const RenderScene scene = distant_scene();
    const FloatImage exact = reference(map, scene, 1024);
    // The lobes are exact. 1024 samples estimate the shares of both kinds of texels with an error of about 1 %.
    EXPECT_LT(picture_error(movmf(map, scene), exact).relative_l1, 0.02);
    EXPECT_GT(picture_error(baseline(map, scene, Baseline::kMip), exact).relative_l1, 0.10);
  }
}

// The weights of the filter are known for linear quantities, such as colours over a flat map.
TEST_P(RenderTest, TheReferenceOfTexelsIsWhatTheFilterAverages) {
  for (const WrapMode wrap : {WrapMode::kPeriodic, WrapMode::kClamp, WrapMode::kMirror, WrapMode::kBlack}) {
    TestMap map = make_flat_map(24);  // the levels have 12, 6, 3 and 1 texels
    map.image.wrap_s = map.image.wrap_t = wrap;
    for (std::size_t i = 0; i < map.image.normals.size(); ++i)
      map.image.albedo.emplace_back(i % 2 == 0 ? 1.0f : 0.1f, i % 24 < 12 ? 0.8f : 0.2f, i % 7 < 3 ? 0.9f : 0.3f);
    RenderScene scene;
    scene.uv_scale = wrap == WrapMode::kBlack ? 1.0f : 9.0f;  // a repeat of the map ends at the near border of the
                                                              // plane
    scene.brdf.specular = glm::vec3(0.0f);
    const NormalMaterial texels(context_->functions(), map.image, NormalMaterial::Sampling::kFootprint, 1.0f);
    for (const TextureFilter& filter : {TextureFilter{}, TextureFilter{1, 0.0f, false, false}}) {
      scene.filter = filter;
      const FloatImage drawn = renderer_->draw_reference(*mesh_, texels, scene, {512}).image;
      const FloatImage filtered = baseline(map, scene, Baseline::kMip);
      EXPECT_LT(picture_error(drawn, filtered).relative_l1, 0.01) << wrap_mode_name(wrap) << ", " << filter.taps;
      if (filter.taps == 1) {
        EXPECT_GT(picture_error(reference(map, scene, 64), filtered).relative_l1, 0.03)
            << "the pixel's reference is another";
      }
    }
  }
}

// If lobes are not aligned, the filter mixes different lobes with one another, unless they are shaded before filtering.
// Aligned lobes give the same picture both ways.
TEST_P(RenderTest, ShadingFirstNeedsNoAlignment) {
  TestMap map = make_two_tilt_map(64, 25.0, StorageEncoding::kFloat, false);
  const RenderScene scene = distant_scene();
  const auto draw = [&](bool shade_first) {
    MovmfMaterial material(context_->functions(), map.mipmap, 1.0f, &map.image);
    material.set_shade_first(shade_first);
    return renderer_->draw(*mesh_, material, scene).image;
  };
  const FloatImage aligned = draw(false);
  EXPECT_LT(picture_error(draw(true), aligned).relative_l1, 0.03);
  for (MovmfLevel& level : map.mipmap.levels)
    for (std::size_t i = 0; i < level.lobes[0].size(); i += 2) std::swap(level.lobes[0][i], level.lobes[1][i]);
  EXPECT_LT(picture_error(draw(true), aligned).relative_l1, 0.03);
  EXPECT_GT(picture_error(draw(false), aligned).relative_l1, 0.2);
}

TEST_P(RenderTest, ColoursFollowTheirLobes) {
  const TestMap map = make_two_tilt_map(64, 40.0, StorageEncoding::kSnorm16, true);
  RenderScene scene = distant_scene();
  scene.brdf.specular = glm::vec3(0.0f);
  scene.lights = {{{0.2f, 0.0f, 1.0f}, glm::vec3(3.0f)}};  // this light reaches both tilts
  EXPECT_LT(picture_error(movmf(map, scene), reference(map, scene, 256)).relative_l1, 0.03);
  scene.lights = {{{1.0f, 0.0f, 0.2f}, glm::vec3(3.0f)}};  // this light reaches only the red tilt
  const FloatImage exact = reference(map, scene, 1024);
  const FloatImage drawn = movmf(map, scene);
  EXPECT_LT(picture_error(drawn, exact).relative_l1, 0.02);
  const std::size_t centre = 4 * (kRenderHeight / 2 * kRenderWidth + kRenderWidth / 2);
  EXPECT_GT(drawn.rgba[centre], 5.0f * drawn.rgba[centre + 2]);
  EXPECT_GT(picture_error(baseline(map, scene, Baseline::kMip), exact).relative_l1, 0.3);
}

TEST_P(RenderTest, FirstRowOfTheMapIsItsTop) {
  // The view is from straight above, and v increases upwards in the picture. The white first row of the map is in the
  // upper half of the picture. Normals that lean up (+Y) face a light that shines from the upper edge of the picture.
  TestMap map = make_flat_map(2);
  map.image.albedo = {glm::vec3(1.0f), glm::vec3(1.0f), glm::vec3(0.1f), glm::vec3(0.1f)};
  MovmfLevel& finest = map.mipmap.levels[0];
  finest.colours = {map.image.albedo};
  map.mipmap.levels[1].colours = {{glm::vec3(0.55f)}};
  for (std::size_t i = 0; i < 4; ++i) {
    map.image.normals[i] = {0.0f, i < 2 ? 0.6f : -0.6f, 0.8f};
    finest.lobes[0][i] = glm::vec4(map.image.normals[i], 1.0f);
  }
  RenderScene scene;
  scene.camera.eye = {0.0f, 30.0f, 60.0f};
  scene.camera.target = {0.0f, 30.0f, 0.0f};
  scene.camera.up = {0.0f, 1.0f, 0.0f};
  scene.lights = {{{0.0f, 1.0f, 0.5f}, glm::vec3(3.0f)}};
  for (const FloatImage& image : {movmf(map, scene), reference(map, scene, 1), baseline(map, scene, Baseline::kMip)}) {
    const std::size_t upper = 4 * (kRenderHeight / 4 * kRenderWidth + kRenderWidth / 2);
    const std::size_t lower = 4 * (kRenderHeight * 3 / 4 * kRenderWidth + kRenderWidth / 2);
    EXPECT_GT(image.rgba[upper], 4.0f * image.rgba[lower]);
  }
}

// A picture drawn from a file of moments equals the picture that the same baseline method draws from the finest map.
// Both contexts are llvmpipe on most machines, and compiling takes seconds, so one context draws only some of the
// cases.
TEST_P(RenderTest, MomentsEqualTheBaselines) {
  const std::pair<MomentShading, Baseline> kWays[] = {{MomentShading::kToksvig, Baseline::kToksvig},
                                                      {MomentShading::kLean, Baseline::kLean},
                                                      {MomentShading::kLeanJacobian, Baseline::kLeanJacobian}};
  for (const WrapMode wrap : {WrapMode::kPeriodic, WrapMode::kMirror, WrapMode::kClamp, WrapMode::kBlack}) {
    TestMap map = make_noise_map(32, 1.5f, wrap);
    for (const bool coloured : {false, true}) {
      if (GetParam() == ContextBackend::kEgl && coloured != (wrap == WrapMode::kBlack)) continue;
      for (std::size_t i = 0; coloured && i < map.image.normals.size(); ++i)
        map.image.albedo.emplace_back(0.5f + 0.5f * map.image.normals[i]);
      RenderScene scene;  // the view reaches from magnified to far
      scene.uv_scale = wrap == WrapMode::kPeriodic ? 30.0f : 1.0f;
      // Both exponents are drawn with and without colours, and with two wrap modes each.
      const bool is_sharp = coloured == (wrap == WrapMode::kMirror || wrap == WrapMode::kBlack);
      scene.brdf.exponent = is_sharp ? 500.0f : 20.0f;
      scene.lights = {{{0.3f, 0.7f, 1.0f}, glm::vec3(3.0f)}};
      SCOPED_TRACE(std::string(wrap_mode_name(wrap)) + (coloured ? ", coloured" : ""));
      for (const auto& [shading, which] : kWays) {
        const FloatImage expected = baseline(map, scene, which);
        const FloatImage exact = moments(map, make_moments(map.image, StorageEncoding::kFloat), scene, shading);
        EXPECT_LT(picture_error(exact, expected).relative_l1, 2e-5);
        const FloatImage rounded = moments(map, make_moments(map.image, StorageEncoding::kHalf), scene, shading);
        EXPECT_LT(picture_error(rounded, expected).relative_l1, 5e-3);
      }
      // The pictures differ from one another.
      EXPECT_GT(picture_error(baseline(map, scene, Baseline::kLean), baseline(map, scene, Baseline::kLeanJacobian))
                    .relative_l1,
                0.005);
    }
  }
}

/// Returns a plain that reaches from near to far and shows every level of detail, including magnification. Slopes of up
/// to 0.8 are never in shadow.
RenderScene plain_scene() {
  RenderScene scene;
  scene.uv_scale = 60.0f;
  scene.lights = {{{0.8f, 0.2f, 1.0f}, glm::vec3(3.0f)}};
  scene.brdf.specular = glm::vec3(0.0f);
  return scene;
}

// Levels that the file leaves to the normal map are shaded by Toksvig's rule, whatever rule shades the moments. On
// these levels, pixels show the normals between texels. The stored levels are drawn exactly as from a complete file.
TEST_P(RenderTest, MomentsThatBeginAtACoarserLevel) {
  TestMap map = make_noise_map(64, 0.8f, WrapMode::kPeriodic);
  const MomentMipmap whole = make_moments(map.image, StorageEncoding::kFloat);
  MomentMipmap coarse = whole;
  coarse.header.first_level = 2;
  for (std::size_t l = 0; l < 2; ++l) coarse.levels[l] = {coarse.levels[l].width, coarse.levels[l].height, {}, {}, {}};
  const RenderScene far = distant_scene();
  for (const MomentShading shading : {MomentShading::kToksvig, MomentShading::kLean, MomentShading::kLeanJacobian})
    EXPECT_LT(picture_error(moments(map, coarse, far, shading), moments(map, whole, far, shading)).relative_l1, 1e-6);
  RenderScene near = plain_scene();
  look_from_above(near, 2.05, 64, kRenderHeight);
  const FloatImage toksvig = baseline(map, near, Baseline::kToksvig);
  for (const MomentShading shading : {MomentShading::kToksvig, MomentShading::kLean, MomentShading::kLeanJacobian})
    EXPECT_LT(picture_error(moments(map, coarse, near, shading), toksvig).relative_l1, 1e-5);
  try {
    const MomentMaterial material(context_->functions(), coarse, 1.0f, nullptr);
    ADD_FAILURE() << "no normal map";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("expected the baked normal map of 64 x 64 texels"), std::string::npos)
        << error.what();
  }
  MomentMipmap cut = whole;
  cut.levels[2].slopes.pop_back();
  EXPECT_THROW(MomentMaterial(context_->functions(), cut, 1.0f), Error);
}

TEST_P(RenderTest, WrapModesEqualReference) {
  // The view is from straight above, with a corner of the map in the middle of the picture. The map's last row and
  // column end at x = -10 and y = 40, and three quarters of the picture are beyond the border.
  RenderScene scene;
  scene.camera.eye = {-10.0f, 40.0f, 30.0f};
  scene.camera.target = {-10.0f, 40.0f, 0.0f};
  scene.camera.up = {0.0f, 1.0f, 0.0f};
  scene.uv_scale = 3.0f;
  scene.brdf.exponent = 20.0f;
  scene.lights = {{{0.6f, 0.4f, 1.0f}, glm::vec3(3.0f)}};
  std::vector<FloatImage> exact;
  for (const WrapMode wrap : {WrapMode::kPeriodic, WrapMode::kMirror, WrapMode::kClamp, WrapMode::kBlack}) {
    const TestMap map = make_wave_map(64, wrap);
    exact.push_back(reference(map, scene, 64));
    const FloatImage drawn = movmf(map, scene);
    EXPECT_LT(picture_error(drawn, exact.back()).relative_l1, 0.02) << wrap_mode_name(wrap);
    for (const Baseline which : {Baseline::kMip, Baseline::kToksvig, Baseline::kLean, Baseline::kLeanJacobian})
      EXPECT_LT(picture_error(baseline(map, scene, which), exact.back()).relative_l1, 0.2) << wrap_mode_name(wrap);
    if (wrap != WrapMode::kBlack) continue;
    const std::size_t beyond = 4 * (kRenderHeight / 4 * kRenderWidth + kRenderWidth * 3 / 4);
    EXPECT_EQ(drawn.rgba[beyond], 0.0f);
    EXPECT_EQ(exact.back().rgba[beyond], 0.0f);
    for (const Baseline which : {Baseline::kMip, Baseline::kToksvig, Baseline::kLean, Baseline::kLeanJacobian})
      EXPECT_EQ(baseline(map, scene, which).rgba[beyond], 0.0f);
  }
  for (std::size_t i = 1; i < exact.size(); ++i)
    EXPECT_GT(picture_error(exact[i], exact[0]).relative_l1, 0.1) << "the modes must give different pictures";
}

// Diffuse light on mild slopes is linear in the mean normal. Hence shading a lobe that the hardware mixed from two
// levels equals mixing two shaded lobes. Only wrong weights or a wrong level would show.
TEST_P(RenderTest, TheNormalMapsLevelsMixWithTheLobesAsTrilinearFilteringMixes) {
  const TestMap map = make_noise_map(64, 0.4f, WrapMode::kPeriodic);
  RenderScene scene = plain_scene();
  scene.uv_scale = 350.0f;  // The map is never magnified, because a magnified normal map has narrower highlights.
  const FloatImage whole = movmf(map, scene);
  // This control checks that the picture can show an error: every level is one step too coarse.
  TestMap blurred = map;
  for (glm::vec4& lobe : blurred.mipmap.levels[0].lobes[0]) lobe = glm::vec4(0.0f, 0.0f, 0.95f, 1.0f);
  EXPECT_GT(picture_error(movmf(blurred, scene), whole).relative_l1, 0.002);
  for (const int first_level : {1, 2, 3, 6})
    EXPECT_LT(picture_error(movmf_from(first_level, map, scene), whole).relative_l1,
              filter_tolerance(*context_, 1e-5, 1e-3))
        << first_level;
}

TEST_P(RenderTest, TheFinestLevelsTakeTheirColoursFromTheAlbedoMap) {
  TestMap map = make_flat_map(32);
  SplitMix64 random(5);
  for (std::size_t i = 0; i < map.image.normals.size(); ++i)
    map.image.albedo.emplace_back(random.uniform(), random.uniform(), random.uniform());
  std::vector<glm::vec3> colours = map.image.albedo;
  for (std::size_t l = 0, columns = 32;; ++l, columns /= 2) {
    map.mipmap.levels[l].colours = {colours};
    if (columns == 1) break;
    std::vector<glm::vec3> coarse;
    for (std::size_t y = 0; y < columns; y += 2)
      for (std::size_t x = 0; x < columns; x += 2) {
        const glm::vec3* const upper = &colours[y * columns + x];
        coarse.push_back(0.25f * (upper[0] + upper[1] + upper[columns] + upper[columns + 1]));
      }
    colours = std::move(coarse);
  }
  map.mipmap.header.encoding = StorageEncoding::kFloat;
  const RenderScene scene = plain_scene();
  const FloatImage whole = movmf(map, scene);
  for (const int first_level : {1, 3})
    EXPECT_LT(picture_error(movmf_from(first_level, map, scene), whole).relative_l1,
              filter_tolerance(*context_, 1e-5, 1e-3))
        << first_level;
  map.image.albedo.clear();
  // Without the albedo map, the colours of level 3 are magnified.
  const FloatImage without = movmf_from(3, map, scene);
  EXPECT_GT(picture_error(without, whole).relative_l1, 0.02);
  EXPECT_LT(picture_error(without, whole).relative_l1, 0.3);
}

TEST_P(RenderTest, BeyondABlackBorderTheNormalMapHasNoMaterialEither) {
  const TestMap map = make_noise_map(16, 0.4f, WrapMode::kBlack);
  RenderScene scene = plain_scene();
  look_from_above(scene, 1.6, 16, kRenderHeight);
  scene.camera.eye = {-10.0f, 40.0f, 30.0f};
  scene.camera.target = {-10.0f, 40.0f, 0.0f};
  scene.uv_scale *= 2.0f;  // the view is from half the height
  const FloatImage whole = movmf(map, scene), coarse = movmf_from(1, map, scene);
  EXPECT_EQ(coarse.rgba[4 * (kRenderHeight / 4 * kRenderWidth + kRenderWidth * 3 / 4)], 0.0f);
  EXPECT_LT(picture_error(coarse, whole).relative_l1, 1e-5);
}

// Where level 1 is the finest level seen, the pictures differ only by rounding.
TEST_P(RenderTest, FromTheFirstLevelOnNothingChanges) {
  const RenderScene far = distant_scene();
  for (const bool coloured : {false, true}) {
    const TestMap map = make_two_tilt_map(64, 25.0, StorageEncoding::kSnorm16, coloured);
    EXPECT_LT(picture_error(movmf_from(1, map, far), movmf(map, far)).relative_l1, 1e-5);
  }
}

TEST_P(RenderTest, EveryVariantCompilesAndDraws) {
  for (const int variant : {0, 1, 2, 3}) {
    const bool coloured = variant % 2 == 1;
    TestMap map = make_two_tilt_map(8, 20.0, StorageEncoding::kFloat, coloured);
    if (variant >= 2) drop_finer_levels(map.mipmap, 2);
    for (const BrdfKind kind : {BrdfKind::kBlinnPhong, BrdfKind::kTorranceSparrow}) {
      RenderScene scene = distant_scene();
      scene.brdf.kind = kind;
      std::vector<FloatImage> pictures = {movmf(map, scene), reference(map, scene, 2)};
      if (kind == BrdfKind::kBlinnPhong) pictures.push_back(movmf(map, scene, LobeFormula::kPaper));
      for (const Baseline which : {Baseline::kMip, Baseline::kToksvig, Baseline::kLean, Baseline::kLeanJacobian})
        pictures.push_back(baseline(map, scene, which));
      for (const FloatImage& picture : pictures) {
        EXPECT_TRUE(std::all_of(picture.rgba.begin(), picture.rgba.end(), [](float v) { return std::isfinite(v); }));
        EXPECT_GT(*std::max_element(picture.rgba.begin(), picture.rgba.end()), 0.01f);
      }
    }
  }
}

// Both contexts are llvmpipe on most machines, which takes half a second for each number of lobes. Hence only one
// context draws all of them.
TEST_P(RenderTest, EveryLobeCountDraws) {
  for (std::size_t lobes = 1; lobes <= kLobeCountMax; ++lobes) {
    if (GetParam() == ContextBackend::kEgl && lobes != 1 && lobes != 3 && lobes != kLobeCountMax) continue;
    TestMap map = make_flat_map(4);
    for (MovmfLevel& level : map.mipmap.levels) {
      level.lobes.resize(lobes, level.lobes[0]);
      for (auto& lobe : level.lobes)
        for (glm::vec4& texel : lobe) texel /= static_cast<float>(lobes);
      const glm::vec3 white(1.0f / static_cast<float>(lobes));
      level.colours.assign(lobes, std::vector<glm::vec3>(level.lobes[0].size(), white));
    }
    map.image.albedo.assign(16, glm::vec3(1.0f));
    const RenderScene scene = distant_scene();
    const FloatImage plain = movmf(make_flat_map(4), scene);
    EXPECT_LT(picture_error(movmf(map, scene), plain).relative_l1, 1e-3) << lobes;
    EXPECT_LT(picture_error(movmf_from(1, map, scene), plain).relative_l1, 1e-3) << lobes << ", and two maps";
  }
}

TEST_P(RenderTest, SameInputGivesSameBytes) {
  const TestMap map = make_two_tilt_map(16, 20.0, StorageEncoding::kSnorm16, false);
  EXPECT_EQ(movmf(map, distant_scene()).rgba, movmf(map, distant_scene()).rgba);
  EXPECT_EQ(reference(map, distant_scene(), 8).rgba, reference(map, distant_scene(), 8).rgba);
}

TEST_P(RenderTest, NearerSurfacesHideWhatLiesBehind) {
  // Draws two parallel quads, the farther one first. The sum of the reference must contain only the nearer one.
  MeshData two = make_quad(60.0f);
  for (std::size_t i = 0; i < 4; ++i) {
    two.vertices.push_back(two.vertices[i]);
    two.vertices.back().position.z += 1.0f;
  }
  two.indices.insert(two.indices.end(), {4, 5, 6, 4, 6, 7});
  const TestMap map = make_flat_map(4);
  const NormalMaterial material(context_->functions(), map.image, NormalMaterial::Sampling::kNearest, 1.0f);
  const Mesh mesh(context_->functions(), two);
  const FloatImage image = renderer_->draw_reference(mesh, material, distant_scene(), {4}).image;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) ASSERT_LE(image.rgba[i], 1.0f);
}

INSTANTIATE_TEST_SUITE_P(Backends, RenderTest, testing::ValuesIn(test_backends()),
                         [](const auto& test) { return std::string(context_backend_name(test.param)); });

TEST(Render, OsmesaEqualsEgl) {
  if (test_backends().size() < 2) GTEST_SKIP() << "MULTUM_TEST_GL names one context";
  const TestMap map = make_two_tilt_map(16, 20.0, StorageEncoding::kSnorm16, true);
  std::vector<FloatImage> pictures;
  std::string software;
  for (const ContextBackend backend : {ContextBackend::kOsmesa, ContextBackend::kEgl}) {
    const auto context = make_test_context(backend);
    const Mesh mesh(context->functions(), make_quad(60.0f));
    Renderer renderer(context->functions(), kRenderWidth, kRenderHeight);
    const MovmfMaterial material(context->functions(), map.mipmap, 1.0f);
    RenderScene scene;
    scene.uv_scale = 60.0f;
    pictures.push_back(renderer.draw(mesh, material, scene).image);
    software += gl_string(context->functions(), GL_RENDERER).find("llvmpipe") != std::string::npos ? "s" : "g";
  }
  // If both contexts use the same rasteriser, the bits are equal. If EGL uses a GPU, rounding and the level of detail
  // may differ.
  if (software == "ss") {
    EXPECT_EQ(pictures[0].rgba, pictures[1].rgba);
  } else {
    EXPECT_LT(picture_error(pictures[1], pictures[0]).relative_l1, 0.02);
  }
}

TEST(Camera, FramesPointsFromTheirFront) {
  std::vector<glm::vec3> points;
  for (int corner = 0; corner < 8; ++corner)
    points.emplace_back(corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f, corner & 4 ? 1.0f : -1.0f);
  const Camera y_up = frame_points(points, {0.0f, 1.0f, 0.0f}, 1.0f);
  EXPECT_GT(y_up.eye.x, 0.0f);
  EXPECT_GT(y_up.eye.y, 0.0f);
  EXPECT_GT(y_up.eye.z, 0.0f);
  const Camera z_up = frame_points(points, {0.0f, 0.0f, 1.0f}, 1.0f);  // the same points, turned by 90 degrees about X
  EXPECT_NEAR(z_up.eye.x, y_up.eye.x, 1e-5f);
  EXPECT_NEAR(z_up.eye.y, -y_up.eye.z, 1e-5f);
  EXPECT_NEAR(z_up.eye.z, y_up.eye.y, 1e-5f);
  EXPECT_EQ(frame_points(points, {1.0f, 0.0f, 0.0f}, 1.0f).up.x, 1.0f);
}

// For random point sets of every shape and place, all points are visible and centred, and they touch two opposite sides
// of the picture.
TEST(Camera, PointsFillThePicture) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    const glm::vec3 scale(std::exp2(4.0f * unit(random)), std::exp2(4.0f * unit(random)),
                          std::exp2(4.0f * unit(random)));
    const glm::vec3 place = 20.0f * glm::vec3(unit(random), unit(random), unit(random));
    std::vector<glm::vec3> points;
    for (int i = 0; i < 50; ++i) points.push_back(place + scale * glm::vec3(unit(random), unit(random), unit(random)));
    const int width = 100 + 50 * (round % 7), height = 300;
    const Camera camera = frame_points(points, {0.0f, 1.0f, 0.0f}, static_cast<float>(width) / height);
    glm::vec2 low(1e9f), high(-1e9f);
    for (const glm::vec3& point : points) {
      const glm::vec4 clip = view_projection(camera, width, height, glm::vec2(0.0f)) * glm::vec4(point, 1.0f);
      EXPECT_LT(std::abs(clip.z), clip.w) << "between the near and the far plane";
      low = glm::min(low, glm::vec2(clip) / clip.w);
      high = glm::max(high, glm::vec2(clip) / clip.w);
    }
    const float least = std::min({low.x, low.y, -high.x, -high.y});
    EXPECT_GT(least, -0.95f);
    const bool is_wide = high.x > 0.93f && low.x<-0.93f, is_high = high.y> 0.93f && low.y < -0.93f;
    EXPECT_NEAR(low.x, -high.x, 1e-3f);
    EXPECT_NEAR(low.y, -high.y, 1e-3f);
    EXPECT_TRUE(is_wide || is_high) << low.x << " " << high.x << " " << low.y << " " << high.y;
  }
}

// The camera's target varies from the middle of the points to far behind them.
TEST(Camera, WhatWasSeenIsSeenFromFartherAway) {
  const std::vector<glm::vec3> points = {{1.0f, 0.0f, 0.0f}, {-1.0f, 0.5f, 0.2f}, {0.1f, -0.3f, 1.0f}};
  const Camera framed = frame_points(points, {0.0f, 1.0f, 0.0f}, 1.5f);
  Camera beyond = framed;
  beyond.target = framed.eye + 30.0f * (framed.target - framed.eye);
  for (const auto& [camera, nearest] : {std::pair{framed, 0.9f}, std::pair{beyond, 1.0f}})
    for (const float factor : {nearest, 1.0f, 5.0f, 25.0f, 1000.0f}) {
      const Camera moved = moved_away(camera, factor);
      EXPECT_NEAR(glm::length(moved.eye - moved.target) / (factor * glm::length(camera.eye - camera.target)), 1.0,
                  1e-5);
      for (const glm::vec3& point : points) {
        const glm::vec4 clip = view_projection(moved, 300, 200, glm::vec2(0.0f)) * glm::vec4(point, 1.0f);
        EXPECT_GT(clip.w, 0.0f) << factor;
        EXPECT_LT(std::abs(clip.z), clip.w) << factor;
      }
    }
}

TEST(Material, RefusesLevelsThatDoNotFit) {
  const auto context = make_test_context(test_backend());
  MovmfMipmap broken = make_flat_map(8).mipmap;
  broken.levels[1].lobes[0].pop_back();
  try {
    const MovmfMaterial material(context->functions(), broken, 1.0f);
    FAIL() << "a level with a missing texel was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    EXPECT_STREQ(error.what(), "level 1 of the baked map does not have 4 x 4 texels of 1 lobes");
  }
  EXPECT_THROW(MovmfMaterial(context->functions(), MovmfMipmap{}, 1.0f), Error);
}

TEST(Material, RefusesFinestLevelsWithoutTheirNormalMap) {
  const auto context = make_test_context(test_backend());
  TestMap map = make_flat_map(8);
  drop_finer_levels(map.mipmap, 1);
  const NormalImage other = make_flat_map(4).image;
  const auto refusal = [&](const NormalImage* source) -> std::string {
    try {
      const MovmfMaterial material(context->functions(), map.mipmap, 1.0f, source);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      return error.what();
    }
    return "taken";
  };
  EXPECT_NE(refusal(nullptr).find("8 x 8"), std::string::npos);
  EXPECT_NE(refusal(&other).find("4 x 4"), std::string::npos);
  EXPECT_EQ(refusal(&map.image), "taken");
}

TEST(PictureError, CountsRgbOnly) {
  const FloatImage reference{2, 1, {1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f}};
  FloatImage picture = reference;
  picture.rgba[0] = 1.6f;
  picture.rgba[3] = 9.0f;
  const PictureError error = picture_error(picture, reference);
  EXPECT_NEAR(error.relative_l1, 0.1, 1e-7);
  EXPECT_NEAR(error.rmse, 0.6 / std::sqrt(6.0), 1e-7);
}

TEST(ContactSheet, PlacesPicturesUnderTheirLabels) {
  const FloatImage red{8, 4, std::vector<float>(128, 0.25f)};
  const FloatImage sheet = make_contact_sheet({{{"a", red}, {"b", red}}, {{"c", red}}}, 1.0f);
  EXPECT_EQ(sheet.width, 8 + 4 + 8);
  const std::size_t below = 4 * static_cast<std::size_t>((sheet.height - 1) * sheet.width);
  EXPECT_EQ(sheet.rgba[below], 0.25f);          // third picture
  EXPECT_EQ(sheet.rgba[below + 4 * 13], 0.0f);  // the area next to the pictures is black
}

TEST(ContactSheet, LabelsAreWholeHoweverSmallThePictures) {
  // A dash has five white pixels at scale 1. No other pixel is white.
  const std::string label(20, '-');
  const auto ink = [&](int width) {
    const FloatImage dark{width, 4, std::vector<float>(static_cast<std::size_t>(16 * width), 0.0f)};
    const FloatImage sheet = make_contact_sheet({{{"", dark}, {label, dark}}, {{label, dark}}}, 1.0f);
    std::ptrdiff_t count = 0;
    for (std::size_t i = 0; i < sheet.rgba.size(); i += 4) count += sheet.rgba[i] == 1.0f;
    return count;
  };
  EXPECT_EQ(ink(8), 2 * 20 * 5);
  EXPECT_EQ(ink(122), 2 * 20 * 5);
  EXPECT_EQ(ink(244), 2 * 20 * 10 * 2);
  EXPECT_EQ(ink(1220), 2 * 20 * 15 * 3) << "twice as wide as a window, so letters are three times as large";
}

TEST(ContactSheet, ALegendShowsTheScaleOfDifferences) {
  const FloatImage legend = difference_legend(400, 300, 4.0f, 2.0f);
  ASSERT_EQ(legend.width, 400);
  ASSERT_EQ(legend.height, 300);
  const auto value = [&](int x) { return legend.rgba[4 * static_cast<std::size_t>(150 * 400 + x)]; };
  EXPECT_LT(value(10), 0.1f);
  EXPECT_NEAR(value(200), 1.0f, 0.02f);
  EXPECT_GT(value(390), 1.9f);
}

}  // namespace
}  // namespace multum::gl
