// SPDX-License-Identifier: Apache-2.0
// Tests the texture filter of shaders/common/texture_filter.glsl and the references that measure it.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include <glm/trigonometric.hpp>

#include "runtime_gl/materials/mip_texture.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tests/gl/sh_test_map.h"
#include "tests/gl/shader_harness.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"

namespace multum::gl {
namespace {

constexpr TextureFilter kPlain{1, 0.0f, false, false};
constexpr TextureFilter kDriver{1, 0.0f, false, true};

class TextureFilterTest : public testing::TestWithParam<ContextBackend> {
 protected:
  void SetUp() override {
    context_ = make_test_context(GetParam());
    mesh_ = std::make_unique<Mesh>(context_->functions(), make_quad(60.0f));
    renderer_ = std::make_unique<Renderer>(context_->functions(), 80, 60);
  }
  void TearDown() override {
    if (context_ == nullptr) return;
    EXPECT_NO_THROW(check_gl(context_->functions(), "end of the test"));
  }

  FloatImage drawn(const Material& material, RenderScene scene, const TextureFilter& filter) {
    scene.filter = filter;
    return renderer_->draw_once(*mesh_, material, scene);
  }
  FloatImage reference(const NormalImage& image, NormalMaterial::Sampling sampling, const RenderScene& scene) {
    const NormalMaterial material(context_->functions(), image, sampling, 1.0f);
    return renderer_->draw_reference(*mesh_, material, scene, {1024}).image;
  }
  double error_of(const FloatImage& picture, const FloatImage& reference_picture) {
    return picture_error(picture, reference_picture).relative_l1;
  }

  std::unique_ptr<HeadlessContext> context_;
  std::unique_ptr<Mesh> mesh_;
  std::unique_ptr<Renderer> renderer_;
};

// Returns random colours under a flat map, because filtering is linear in colours and no highlight hides the colours.
NormalImage coloured_image(int size) {
  NormalImage image{size, size, {}, {}};
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < size * size; ++i) {
    image.normals.emplace_back(0.0f, 0.0f, 1.0f);
    image.albedo.emplace_back(unit(random), unit(random), unit(random));
  }
  return image;
}

RenderScene matt_scene() {
  RenderScene scene;
  scene.uv_scale = 60.0f;
  scene.brdf.specular = glm::vec3(0.0f);
  return scene;
}

// Interpolates one level of a periodic map bilinearly.
glm::dvec4 bilinear(const std::vector<float>& texels, int size, glm::dvec2 st) {
  const glm::dvec2 place = st * static_cast<double>(size) - 0.5, low = glm::floor(place), share = place - low;
  glm::dvec4 sum(0.0);
  for (int k = 0; k < 4; ++k) {
    const auto wrapped = [size](double i) { return ((static_cast<int>(i) % size) + size) % size; };
    const int x = wrapped(low.x + k % 2), y = wrapped(low.y + k / 2);
    const double weight = (k % 2 == 0 ? 1.0 - share.x : share.x) * (k / 2 == 0 ? 1.0 - share.y : share.y);
    for (int c = 0; c < 4; ++c)
      sum[c] += weight *
                static_cast<double>(texels[4 * static_cast<std::size_t>(y * size + x) + static_cast<std::size_t>(c)]);
  }
  return sum;
}

// Compares the shader's lookups for given footprints with the definition in double precision.
TEST_P(TextureFilterTest, TapsAreTheirsInDouble) {
  constexpr int kSize = 16, kLevels = 5;
  TexelPlane plane{kSize, kSize, {}};
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < kSize * kSize; ++i) plane.texels.emplace_back(unit(random), unit(random), unit(random), 1.0f);
  const SamplerSettings sampler{WrapMode::kPeriodic, WrapMode::kPeriodic, true, 1.0f};
  const Texture map = upload_mips(context_->functions(), "map", plane, kLevels, sampler);
  std::vector<std::vector<float>> levels;
  for (int l = 0; l < kLevels; ++l) levels.push_back(map.read_level(l));
  for (const int taps : {1, 4}) {
    ShaderHarnessInput input;
    input.flags = {"MULTUM_TAPS 4"};
    if (taps == 1) input.flags.clear();
    input.texture = &map;
    input.expression = "multum_filtered(map, a.xy, MultumFootprint(a.zw, int(b.x), b.y))";
    for (int i = 0; i < 60; ++i) {
      input.a.emplace_back(3.0f * unit(random) - 1.0f, unit(random), 0.2f * unit(random), 0.2f * unit(random));
      input.b.emplace_back(static_cast<float>(taps == 1 ? 1 : 1 + i % taps), 7.0f * unit(random) - 1.5f, 0.0f, 0.0f);
    }
    const std::vector<glm::vec4> found = evaluate_shader(context_->functions(), input);
    const double tolerance = filter_tolerance(*context_, 2e-5, 2e-2);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const glm::dvec4 a(input.a[i]);
      const int count = static_cast<int>(input.b[i].x);
      const double level = std::clamp(static_cast<double>(input.b[i].y), 0.0, kLevels - 1.0);
      const int fine = std::min(static_cast<int>(level), kLevels - 2);
      glm::dvec4 exact(0.0);
      for (int tap = 0; tap < count; ++tap) {
        const glm::dvec2 st = glm::dvec2(a) + (tap - 0.5 * (count - 1)) * glm::dvec2(a.z, a.w);
        const double share = level - fine;
        exact += (1.0 - share) * bilinear(levels[static_cast<std::size_t>(fine)], kSize >> fine, st) / (1.0 * count) +
                 share * bilinear(levels[static_cast<std::size_t>(fine) + 1], kSize >> (fine + 1), st) / (1.0 * count);
      }
      for (int c = 0; c < 4; ++c)
        EXPECT_NEAR(static_cast<double>(found[i][c]), exact[c], tolerance) << "taps " << count << ", level " << level;
    }
  }
}

// One tap without a bias equals the driver's trilinear filter, except that the driver approximates the level.
TEST_P(TextureFilterTest, OneTapIsTheDriversTrilinear) {
  const NormalImage image = coloured_image(64);
  NormalMaterial material(context_->functions(), image, NormalMaterial::Sampling::kMipmapped, 1.0f);
  const FloatImage driver = drawn(material, matt_scene(), kDriver);
  EXPECT_LT(error_of(drawn(material, matt_scene(), kPlain), driver), 0.01);
  EXPECT_GT(error_of(drawn(material, matt_scene(), {1, -1.0f, false, false}), driver), 0.02) << "a bias is seen";
}

// The plane reaches the horizon, so that pixels are many times longer than wide.
TEST_P(TextureFilterTest, TapsComeNearerThePixel) {
  const NormalImage image = coloured_image(64);
  NormalMaterial material(context_->functions(), image, NormalMaterial::Sampling::kMipmapped, 1.0f);
  const RenderScene scene = matt_scene();
  const FloatImage exact = reference(image, NormalMaterial::Sampling::kNearest, scene);
  double before = error_of(drawn(material, scene, kPlain), exact);
  for (const int taps : {2, 4, 16}) {
    const double error = error_of(drawn(material, scene, {taps, 0.0f, false, false}), exact);
    // Only few pixels are more than 4 times as long as wide.
    EXPECT_LT(error, (taps > 4 ? 1.0 : 0.95) * before) << taps << " taps";
    // Linear quantities do not depend on whether taps are shaded before or after averaging.
    EXPECT_NEAR(error_of(drawn(material, scene, {taps, 0.0f, true, false}), exact), error, 1e-4) << taps << " taps";
    before = error;
  }
}

TEST_P(TextureFilterTest, AFlatMapIsTheSameByEveryFilter) {
  const TestMap map = make_flat_map(16);
  std::vector<std::unique_ptr<Material>> materials;
  const GlFunctions& gl = context_->functions();
  materials.push_back(std::make_unique<MovmfMaterial>(gl, map.mipmap, 1.0f));
  materials.push_back(std::make_unique<MomentMaterial>(gl, make_moments(map.image, StorageEncoding::kFloat), 1.0f));
  materials.push_back(std::make_unique<ShMaterial>(gl, make_harmonics(map.image, 4, StorageEncoding::kFloat), 1.0f));
  RenderScene scene;
  scene.uv_scale = 60.0f;
  scene.brdf.exponent = 20.0f;
  for (const auto& material : materials) {
    const FloatImage driver = drawn(*material, scene, kDriver);
    for (const TextureFilter& filter : {kPlain, TextureFilter{4, -0.5f, false, false},
                                        TextureFilter{4, -0.5f, true, false}, TextureFilter{16, 1.0f, false, false}})
      EXPECT_LT(error_of(drawn(*material, scene, filter), driver), 1e-4) << material->name();
  }
}

// Colours come from a texture of another size than the lobes, so that each has its own level.
TEST_P(TextureFilterTest, ColoursOfAnotherSizeHaveTheirOwnLevel) {
  const NormalImage image = coloured_image(64);
  const TestMap flat = make_flat_map(16);
  MovmfMaterial lobes(context_->functions(), flat.mipmap, 1.0f);
  TexelPlane plane{64, 64, {}};
  for (const glm::vec3& colour : image.albedo) plane.texels.emplace_back(colour, 1.0f);
  const SamplerSettings sampler{WrapMode::kPeriodic, WrapMode::kPeriodic, true, 1.0f};
  lobes.set_mean_colours(upload_mips(context_->functions(), "colours", plane, 7, sampler));
  NormalMaterial averages(context_->functions(), image, NormalMaterial::Sampling::kMipmapped, 1.0f);
  for (const TextureFilter& filter : {kPlain, TextureFilter{4, -0.5f, false, false}})
    EXPECT_LT(error_of(drawn(lobes, matt_scene(), filter), drawn(averages, matt_scene(), filter)), 2e-3);
}

// Magnifies two tilts. Lobes blend the light of the surrounding texels, as the blended reference does. Facets have
// visible edges, and the normal midway between two opposite tilts is upright.
TEST_P(TextureFilterTest, ReferencesBetweenTexels) {
  using Sampling = NormalMaterial::Sampling;
  const TestMap map = make_two_tilt_map(16, 25.0, StorageEncoding::kFloat, false);
  RenderScene scene;
  scene.camera.eye = {0.0f, 1.0f, 6.0f};
  scene.camera.target = {0.0f, 4.0f, 0.0f};
  scene.uv_scale = 1.0f;
  const MovmfMaterial lobes(context_->functions(), map.mipmap, 1.0f);
  const FloatImage baked = drawn(lobes, scene, kPlain);
  EXPECT_LT(error_of(baked, reference(map.image, Sampling::kBlended, scene)), 0.02);
  EXPECT_GT(error_of(baked, reference(map.image, Sampling::kNearest, scene)), 0.10);
  const FloatImage smooth = reference(map.image, Sampling::kInterpolated, scene);
  EXPECT_GT(error_of(baked, smooth), 0.10);
  // Where four texels meet, the normal between them is upright. At least one pixel there is as bright as on a flat map.
  const FloatImage upright = reference(make_flat_map(16).image, Sampling::kNearest, scene);
  double nearest = 1e30;
  for (std::size_t i = 0; i < smooth.rgba.size(); i += 4)
    if (upright.rgba[i] > 0.0f)
      nearest = std::min(nearest, std::abs(static_cast<double>(smooth.rgba[i] / upright.rgba[i]) - 1.0));
  EXPECT_LT(nearest, 0.02);
}

// Draws a map from very near. The map has four quarters with one normal each, or alternating texels. Lobes match the
// interpolation of engines as closely as averaged normals do.
TEST_P(TextureFilterTest, AMagnifiedSurfaceIsThatOfAveragedNormals) {
  NormalImage quarters = make_flat_map(16).image;
  const double tilt = glm::radians(25.0);
  for (std::size_t i = 0; i < quarters.normals.size(); ++i) {
    const double turn = glm::radians(30.0 + 90.0 * static_cast<double>(2 * (i / 128) + (i % 16) / 8));
    quarters.normals[i] = {std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)};
  }
  RenderScene scene;
  scene.camera.eye = {0.0f, 28.0f, 6.0f};
  scene.camera.target = {0.0f, 30.0f, 0.0f};
  scene.uv_scale = 1.0f;
  for (const TestMap& map :
       {make_one_lobe_map(quarters), make_two_tilt_map(16, 25.0, StorageEncoding::kFloat, false)}) {
    MovmfMaterial lobes(context_->functions(), map.mipmap, 1.0f);
    NormalMaterial averages(context_->functions(), map.image, NormalMaterial::Sampling::kMipmapped, 1.0f);
    averages.set_baseline(Baseline::kMip);
    const FloatImage smooth = reference(map.image, NormalMaterial::Sampling::kInterpolated, scene);
    EXPECT_GT(error_of(drawn(lobes, scene, kPlain), smooth), 0.02);
    lobes.set_magnified(true);
    EXPECT_LT(error_of(drawn(lobes, scene, kPlain), smooth), error_of(drawn(averages, scene, kPlain), smooth) + 1e-3);
  }
}

// The picture's difference from a picture with sixteen times as many samples equals the stated noise, within a small
// factor.
TEST_P(TextureFilterTest, TheNoiseOfAReferenceIsWhatItSays) {
  const TestMap map = make_noise_map(64, 0.5f, WrapMode::kPeriodic);
  RenderScene scene;
  scene.uv_scale = 60.0f;
  scene.brdf.exponent = 100.0f;
  const NormalMaterial facets(context_->functions(), map.image, NormalMaterial::Sampling::kNearest, 1.0f);
  const Picture found = renderer_->draw_reference(*mesh_, facets, scene, {0, 0.02});
  EXPECT_LE(found.noise, 0.02);
  EXPECT_GE(found.sample_count, 2 * kReferenceBatch);
  const Picture finer = renderer_->draw_reference(*mesh_, facets, scene, {16 * found.sample_count});
  const double error = error_of(found.image, finer.image);
  EXPECT_LT(error, 1.5 * found.noise);
  EXPECT_GT(error, 0.3 * found.noise);
  EXPECT_TRUE(std::isinf(renderer_->draw_reference(*mesh_, facets, scene, {1}).noise));
}

INSTANTIATE_TEST_SUITE_P(Backends, TextureFilterTest, testing::ValuesIn(test_backends()),
                         [](const auto& test) { return std::string(context_backend_name(test.param)); });

TEST(ReferenceSampling, OffsetsHaveTheirFiltersVariance) {
  // If a Gaussian with a standard deviation of 1/2 is cut off at three standard deviations, its variance is 1/4 (1 - 6
  // phi(3) / (2 Phi(3) - 1)).
  const double phi = std::exp(-4.5) / std::sqrt(2.0 * M_PI);
  const double cut = 0.25 * (1.0 - 6.0 * phi / std::erf(3.0 / std::sqrt(2.0)));
  for (const auto& [filter, variance, width] :
       {std::tuple{PixelFilter::kBox, 1.0 / 12.0, 0.5}, std::tuple{PixelFilter::kTent, 1.0 / 6.0, 1.0},
        std::tuple{PixelFilter::kGaussian, cut, 1.5}}) {
    constexpr int kCount = 4096;
    glm::dvec2 sum(0.0), squares(0.0);
    for (int i = 0; i < kCount; ++i) {
      const glm::dvec2 offset(reference_offset(filter, i));
      EXPECT_LE(std::max(std::abs(offset.x), std::abs(offset.y)), width + 1e-6);
      sum += offset;
      squares += offset * offset;
    }
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_NEAR(sum[axis] / kCount, 0.0, 1e-3);
      EXPECT_NEAR(squares[axis] / kCount, variance, 0.005 * variance);
    }
  }
}

}  // namespace
}  // namespace multum::gl
