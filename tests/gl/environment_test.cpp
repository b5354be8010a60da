// SPDX-License-Identifier: Apache-2.0
// Tests light from an environment. Compares brute force with a sum over the environment's texels in double precision,
// and both ways of filtering with brute force.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/formats/brdf/facet_distribution.h"
#include "host/lab/reference/shading.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/render/environment_background.h"
#include "runtime_gl/render/environment_shading.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tests/gl/sh_test_map.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"

namespace multum::gl {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kWidth = 24, kHeight = 18;

/// Makes a blue sky over brown ground, with a soft sun of `size` radians.
EnvironmentMap make_sky(int height, double size) {
  EnvironmentMap map{2 * height, height, {}};
  const glm::dvec3 sun = glm::normalize(glm::dvec3(0.3, 0.6, -0.8));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < 2 * height; ++x) {
      const glm::dvec3 d = environment_direction((x + 0.5) / (2 * height), (y + 0.5) / height);
      glm::dvec3 light = d.y > 0.0 ? glm::dvec3(0.4, 0.6, 1.0) : glm::dvec3(0.3, 0.2, 0.1);
      light += glm::dvec3(0.8, 0.7, 0.6) / (size * size) *
               std::exp(-glm::length(d - sun) * glm::length(d - sun) / (size * size));
      map.texels.emplace_back(light);
    }
  return map;
}

class EnvironmentTest : public testing::TestWithParam<ContextBackend> {
 protected:
  void SetUp() override {
    context_ = make_test_context(GetParam());
    mesh_ = std::make_unique<Mesh>(context_->functions(), make_quad(60.0f));
    renderer_ = std::make_unique<Renderer>(context_->functions(), kWidth, kHeight);
    scene_.lights.clear();
    scene_.camera.eye = {0.0f, -8.0f, 12.0f};
    scene_.camera.target = {0.0f, 8.0f, 0.0f};
    scene_.uv_scale = 60.0f;
  }
  void TearDown() override {
    if (context_ == nullptr) return;  // no context could be made
    EXPECT_NO_THROW(check_gl(context_->functions(), "end of the test"));
  }
  // Selects highlights without diffuse light, under a sky.
  void make_glossy(float exponent) {
    scene_.environment = make_environment_light(make_sky(64, 0.3));
    scene_.brdf.diffuse = glm::vec3(0.0f);
    scene_.brdf.specular = glm::vec3(1.0f);
    scene_.brdf.exponent = exponent;
  }
  FloatImage lobes(const TestMap& map, EnvironmentMode mode) {
    scene_.environment_mode = mode;
    const MovmfMaterial material(context_->functions(), map.mipmap, 1.0f);
    return renderer_->draw(*mesh_, material, scene_).image;
  }
  FloatImage reference(const TestMap& map, int samples) {
    const NormalMaterial material(context_->functions(), map.image, NormalMaterial::Sampling::kNearest, 1.0f);
    return renderer_->draw_reference(*mesh_, material, scene_, {samples}).image;
  }
  std::unique_ptr<HeadlessContext> context_;
  std::unique_ptr<Mesh> mesh_;
  std::unique_ptr<Renderer> renderer_;
  RenderScene scene_;
};

/// Returns the radiance that leaves the middle point of the picture's plane towards `v`, as a sum over every texel.
glm::dvec3 exact_radiance(const EnvironmentMap& map, const RenderScene& scene, const glm::dvec3& v) {
  glm::dvec3 sum(0.0);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const glm::dvec3 d = environment_direction((x + 0.5) / map.width, (y + 0.5) / map.height);
      const glm::dvec3 l(d.x, -d.z, d.y);  // +Z is up, and the middle of the map is in the direction +Y
      if (l.z <= 0.0) continue;
      const glm::dvec3 h = glm::normalize(l + v);
      const double v_h = glm::dot(v, h), alpha = static_cast<double>(ggx_alpha(scene.brdf));
      glm::dvec3 reflected = glm::dvec3(scene.brdf.diffuse) / kPi;
      if (scene.brdf.kind == BrdfKind::kGgx) {
        const double fresnel = reference::schlick(static_cast<double>(scene.brdf.f0.x), v_h);
        reflected *= 1.0 - fresnel;
        reflected += glm::dvec3(scene.brdf.specular) * fresnel * reference::ggx(alpha, std::acos(std::min(h.z, 1.0))) *
                     reference::smith_visibility(alpha, l.z, v.z);
      } else {
        reflected += glm::dvec3(scene.brdf.specular) *
                     reference::blinn_phong(static_cast<double>(scene.brdf.exponent), std::acos(std::min(h.z, 1.0)));
      }
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(x);
      sum += texel_solid_angle(map.width, map.height, y) * l.z * reflected * glm::dvec3(map.texels[i]);
    }
  return sum;
}

// Seen from above, a rotation moves the direction ahead (+Y) to the left (-X).
TEST(EnvironmentAxes, TurnCounterclockwise) {
  RenderScene scene;
  const std::array<glm::vec3, 3> before = environment_axes(scene);
  EXPECT_LT(glm::distance(-before[2], glm::vec3(0.0f, 1.0f, 0.0f)), 1e-6f);
  EXPECT_LT(glm::distance(before[0], glm::vec3(1.0f, 0.0f, 0.0f)), 1e-6f);
  scene.environment_turn = 90.0f;
  const std::array<glm::vec3, 3> turned = environment_axes(scene);
  EXPECT_LT(glm::distance(-turned[2], glm::vec3(-1.0f, 0.0f, 0.0f)), 1e-6f);
  EXPECT_LT(glm::distance(turned[0], glm::vec3(0.0f, 1.0f, 0.0f)), 1e-6f);
  EXPECT_EQ(turned[1], before[1]);
}

// The background is the sky that lights the scene, whichever way the camera looks.
TEST(EnvironmentBackground, IsTheSkyThatLightsTheScene) {
  const EnvironmentMap map = make_sky(256, 0.3);
  RenderScene scene;
  scene.environment = make_environment_light(map);
  for (const bool is_z_up : {true, false}) {
    scene.environment_up = scene.camera.up = is_z_up ? glm::vec3(0.0f, 0.0f, 1.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
    scene.camera.eye = {3.0f, -2.0f, 1.0f};
    for (const glm::vec3 view :
         {glm::vec3(0.0f, 1.0f, 0.2f), glm::vec3(1.0f, 0.3f, 0.5f), glm::vec3(-0.4f, -1.0f, 0.7f),
          glm::vec3(0.3f, 0.2f, -1.0f), glm::vec3(0.3f, 0.8f, 0.6f)}) {
      scene.camera.target = scene.camera.eye + view;
      const FloatImage image = environment_background(scene, kWidth, kHeight);
      const glm::mat4 inverse = glm::inverse(view_projection(scene.camera, kWidth, kHeight, glm::vec2(0.0f)));
      double off = 0.0, total = 0.0;
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const glm::vec4 far = inverse * glm::vec4(2.0f * (static_cast<float>(x) + 0.5f) / kWidth - 1.0f,
                                                    1.0f - 2.0f * (static_cast<float>(y) + 0.5f) / kHeight, 1.0f, 1.0f);
          const glm::dvec3 w = glm::normalize(glm::dvec3(glm::vec3(far) / far.w - scene.camera.eye));
          // Inverts the rotation of exact_radiance(); with +Y up, the world's axes equal the map's axes.
          const glm::dvec2 st = environment_coordinates(is_z_up ? glm::dvec3(w.x, w.z, -w.y) : w);
          const auto texel = static_cast<std::size_t>(std::min(st.y * map.height, map.height - 1.0)) *
                                 static_cast<std::size_t>(map.width) +
                             static_cast<std::size_t>(std::min(st.x * map.width, map.width - 1.0));
          const std::size_t pixel = 4 * static_cast<std::size_t>(y * kWidth + x);
          for (std::size_t c = 0; c < 3; ++c) {
            const auto expected = static_cast<double>(map.texels[texel][static_cast<glm::length_t>(c)]);
            off += std::abs(static_cast<double>(image.rgba[pixel + c]) - expected);
            total += expected;
          }
          EXPECT_EQ(image.rgba[pixel + 3], 1.0f);
        }
      // A lookup of the nearest texel and a mean of four samples per pixel differ at the horizon and at the sun.
      EXPECT_LT(off / total, 0.03) << is_z_up << " " << view.x << " " << view.y << " " << view.z;
    }
  }
}

TEST(EnvironmentBackground, ShowsAsFarAsThePictureDoesNotCover) {
  const FloatImage picture{3, 1, {1.0f, 2.0f, 3.0f, 1.0f, 0.5f, 1.0f, 1.5f, 0.5f, 0.0f, 0.0f, 0.0f, 0.0f}};
  const FloatImage background{3, 1, {8.0f, 8.0f, 8.0f, 1.0f, 8.0f, 4.0f, 2.0f, 1.0f, 8.0f, 4.0f, 2.0f, 1.0f}};
  const std::vector<float> expected = {1.0f, 2.0f, 3.0f, 1.0f, 4.5f, 3.0f, 2.5f, 1.0f, 8.0f, 4.0f, 2.0f, 1.0f};
  EXPECT_EQ(before_background(picture, background).rgba, expected);
}

TEST_P(EnvironmentTest, BruteForceIsTheSumOverTheTexels) {
  const EnvironmentMap map = make_sky(128, 0.2);
  scene_.environment = make_environment_light(map);
  const TestMap flat = make_flat_map(4);
  for (const BrdfKind kind : {BrdfKind::kBlinnPhong, BrdfKind::kGgx}) {
    scene_.brdf.kind = kind;
    scene_.brdf.exponent = 40.0f;
    scene_.brdf.specular = glm::vec3(kind == BrdfKind::kGgx ? 1.0f : 0.2f);
    scene_.brdf.f0 = glm::vec3(0.6f);
    const FloatImage image = reference(flat, 64);
    const glm::mat4 matrix = view_projection(scene_.camera, kWidth, kHeight, glm::vec2(0.0f));
    double off = 0.0, total = 0.0;
    for (const glm::ivec2 pixel : {glm::ivec2(12, 9), glm::ivec2(3, 12), glm::ivec2(20, 5), glm::ivec2(14, 7)}) {
      const glm::vec4 far =
          glm::inverse(matrix) * glm::vec4(2.0f * (static_cast<float>(pixel.x) + 0.5f) / kWidth - 1.0f,
                                           1.0f - 2.0f * (static_cast<float>(pixel.y) + 0.5f) / kHeight, 1.0f, 1.0f);
      const glm::dvec3 v = glm::normalize(glm::dvec3(scene_.camera.eye - glm::vec3(far) / far.w));
      const glm::dvec3 exact = exact_radiance(map, scene_, v);
      for (int c = 0; c < 3; ++c) {
        const float found =
            image.rgba[4 * static_cast<std::size_t>(pixel.y * kWidth + pixel.x) + static_cast<std::size_t>(c)];
        off += std::abs(static_cast<double>(found) - exact[c]);
        total += exact[c];
      }
    }
    // Each pixel samples 2048 directions. The directions near the sun carry most of the light.
    EXPECT_LT(off / total, 0.02) << "BRDF " << static_cast<int>(kind);
  }
}

TEST_P(EnvironmentTest, ConstantLightIsFilteredExactly) {
  if (GetParam() != test_backend()) GTEST_SKIP() << "one context is enough: the pictures are equal";
  EnvironmentMap white = make_sky(32, 0.2);
  std::fill(white.texels.begin(), white.texels.end(), glm::vec3(1.0f));
  scene_.environment = make_environment_light(white);
  const TestMap map = make_two_tilt_map(16, 25.0, StorageEncoding::kFloat, false);
  for (const BrdfKind kind : {BrdfKind::kBlinnPhong, BrdfKind::kCookTorrance, BrdfKind::kGgx}) {
    scene_.brdf.kind = kind;
    scene_.brdf.exponent = 30.0f;
    scene_.brdf.sigma = 0.2f;
    scene_.brdf.f0 = glm::vec3(0.3f);
    const FloatImage exact = reference(map, 256);  // this estimates the shares of both kinds of texels with an error of
                                                   // about 1.5 %
    for (const EnvironmentMode mode : {EnvironmentMode::kHarmonics, EnvironmentMode::kPrefiltered})
      EXPECT_LT(picture_error(lobes(map, mode), exact).relative_l1, 0.03)
          << "BRDF " << static_cast<int>(kind) << " mode " << static_cast<int>(mode);
  }
}

double light_of(const FloatImage& image) {
  double sum = 0.0;
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
    if (i % 4 != 3) sum += static_cast<double>(image.rgba[i]);
  return sum;
}

// The errors come from the approximations, so a flat map has them too. At s = 100 its error is 12 %, because one lookup
// falls between two levels and the table scales all light by the same factor. If the level is wrong by one half, the
// three highlights of prefiltered levels have errors of 9, 14 and 15 %. If the spread is half as wide, their errors are
// 8.8, 17 and 2 %.
TEST_P(EnvironmentTest, ASkyIsFilteredNearlyAsBruteForceHasIt) {
  if (GetParam() != test_backend()) GTEST_SKIP() << "one context is enough: the pictures are equal";
  scene_.environment = make_environment_light(make_sky(64, 0.3));
  const TestMap map = make_two_tilt_map(16, 20.0, StorageEncoding::kFloat, false);
  const auto error = [&](EnvironmentMode mode, const FloatImage& exact) {
    return picture_error(lobes(map, mode), exact).relative_l1;
  };
  const auto light = [&](EnvironmentMode mode, const FloatImage& exact) {
    return light_of(lobes(map, mode)) / light_of(exact);
  };
  scene_.brdf.specular = glm::vec3(0.0f);
  const FloatImage diffuse = reference(map, 512);
  EXPECT_LT(error(EnvironmentMode::kHarmonics, diffuse), 0.03);
  EXPECT_NEAR(light(EnvironmentMode::kHarmonics, diffuse), 1.0, 0.005);  // measured: 0.05 %
  scene_.brdf.diffuse = glm::vec3(0.0f);
  scene_.brdf.specular = glm::vec3(1.0f);
  scene_.brdf.exponent = 12.0f;
  const FloatImage broad = reference(map, 512);
  EXPECT_LT(error(EnvironmentMode::kHarmonics, broad), 0.065);   // measured: 5.2 %
  EXPECT_LT(error(EnvironmentMode::kPrefiltered, broad), 0.06);  // measured: 4.7 %
  EXPECT_NEAR(light(EnvironmentMode::kHarmonics, broad), 1.0, 0.02);
  EXPECT_NEAR(light(EnvironmentMode::kPrefiltered, broad), 1.0, 0.05);
  scene_.brdf.exponent = 100.0f;
  const FloatImage sharp = reference(map, 512);
  EXPECT_LT(error(EnvironmentMode::kPrefiltered, sharp), 0.12);  // measured: 10.4 %
  EXPECT_NEAR(light(EnvironmentMode::kPrefiltered, sharp), 1.0, 0.05);
  // Harmonics up to order 8 are too smooth for a sharp highlight; prefiltered levels follow it.
  EXPECT_GT(error(EnvironmentMode::kHarmonics, sharp), error(EnvironmentMode::kPrefiltered, sharp));
}

// The harmonics of normals in two directions, 60 degrees apart, are shaded, and not a lobe around the mean of these
// directions.
TEST_P(EnvironmentTest, HarmonicsOfNormalsAreShaded) {
  if (GetParam() != test_backend()) GTEST_SKIP() << "one context is enough: the pictures are equal";
  make_glossy(12.0f);
  scene_.environment_turn = 70.0f;
  const TestMap map = make_two_tilt_map(16, 30.0, StorageEncoding::kFloat, false);
  const FloatImage exact = reference(map, 512);
  const auto error = [&](int order, EnvironmentMode mode) {
    scene_.environment_mode = mode;
    const ShMaterial material(context_->functions(), make_harmonics(map.image, order, StorageEncoding::kFloat), 1.0f);
    return picture_error(renderer_->draw(*mesh_, material, scene_).image, exact).relative_l1;
  };
  EXPECT_LT(error(8, EnvironmentMode::kHarmonics), 0.11);   // measured: 9.9 %, the same as for lobes
  EXPECT_LT(error(4, EnvironmentMode::kHarmonics), 0.15);   // measured: 13.5 %
  EXPECT_GT(error(8, EnvironmentMode::kPrefiltered), 0.2);  // measured: 22.9 %, one lobe
}

// With each BRDF, harmonics have nearly the error of lobes: 7.6 and 9.6 %, 19.2 and 19.3 %, 13.1 and 13.1 %.
TEST_P(EnvironmentTest, HarmonicsOfNormalsAreShadedWithOtherBrdfs) {
  if (GetParam() != test_backend()) GTEST_SKIP() << "one context is enough: the pictures are equal";
  make_glossy(12.0f);
  scene_.environment_mode = EnvironmentMode::kHarmonics;
  scene_.brdf.f0 = glm::vec3(0.5f);
  scene_.brdf.sigma = 0.4f;
  const TestMap map = make_two_tilt_map(16, 30.0, StorageEncoding::kFloat, false);
  const ShMaterial material(context_->functions(), make_harmonics(map.image, 8, StorageEncoding::kFloat), 1.0f);
  for (const BrdfKind kind : {BrdfKind::kGgx, BrdfKind::kCookTorrance, BrdfKind::kTorranceSparrow}) {
    scene_.brdf.kind = kind;
    const FloatImage exact = reference(map, 256);
    const double of_lobes = picture_error(lobes(map, EnvironmentMode::kHarmonics), exact).relative_l1;
    EXPECT_LT(picture_error(renderer_->draw(*mesh_, material, scene_).image, exact).relative_l1, of_lobes + 0.03)
        << "BRDF " << static_cast<int>(kind);
  }
}

// A nearly perfect mirror shows the map. Texels 3 degrees wide blend in one picture and not in the other.
TEST_P(EnvironmentTest, AMirrorShowsTheMap) {
  if (GetParam() != test_backend()) GTEST_SKIP() << "one context is enough: the pictures are equal";
  make_glossy(30000.0f);
  const TestMap flat = make_flat_map(4);
  EXPECT_LT(picture_error(lobes(flat, EnvironmentMode::kPrefiltered), reference(flat, 64)).relative_l1,
            0.03);  // measured: 2.0 %
}

// A highlight that the normals spread widely takes 3 x 3 lookups. Its error is 8.2 %, or 13.6 % if the lookups are too
// close together.
TEST_P(EnvironmentTest, WideHighlightsAreFollowed) {
  if (GetParam() != test_backend()) GTEST_SKIP() << "one context is enough: the pictures are equal";
  make_glossy(40.0f);
  const TestMap noise = make_noise_map(16, 0.3f, WrapMode::kPeriodic);
  EXPECT_LT(picture_error(lobes(noise, EnvironmentMode::kPrefiltered), reference(noise, 256)).relative_l1, 0.10);
}

// The length of a rough normal encodes the width of the BRDF, which does not change diffuse light.
TEST_P(EnvironmentTest, DiffuseLightIsWithoutRoughness) {
  scene_.environment = make_environment_light(make_sky(64, 0.3));
  scene_.brdf.specular = glm::vec3(0.0f);
  const TestMap smooth = make_flat_map(4);
  TestMap rough = smooth;
  rough.mipmap.header.has_roughness = true;
  rough.mipmap.header.mean_cosine = 0.6f;
  for (MovmfLevel& level : rough.mipmap.levels)
    for (glm::vec4& lobe : level.lobes[0]) lobe.z *= rough.mipmap.header.mean_cosine;
  const FloatImage expected = lobes(smooth, EnvironmentMode::kPrefiltered);
  EXPECT_LT(picture_error(lobes(rough, EnvironmentMode::kPrefiltered), expected).relative_l1, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Backends, EnvironmentTest, testing::ValuesIn(test_backends()),
                         [](const auto& test) { return std::string(context_backend_name(test.param)); });

}  // namespace
}  // namespace multum::gl
