// SPDX-License-Identifier: Apache-2.0
// Tests a pixel's budget of evaluations (shaders/common/evaluations.glsl, scene.frag), spent on points or on lobes.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include <glm/geometric.hpp>

#include "runtime_gl/materials/mip_texture.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tests/gl/sh_test_map.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"

namespace multum::gl {
namespace {

TextureFilter filter_of(int evaluations, bool is_turned = false) {
  TextureFilter filter{4, -0.5f, false, false};
  filter.evaluations = evaluations;
  filter.is_turned = is_turned;
  return filter;
}

// Makes a strip of a cylinder about the Y axis. Flat triangles span two edges, and the normals turn from -60 to 60
// degrees.
MeshData turning_quad(float size) {
  MeshData data;
  for (const float side : {-1.0f, 1.0f})
    for (const float up : {0.0f, 1.0f}) {
      const double angle = static_cast<double>(side) * 1.05;
      const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
      data.vertices.push_back(
          {{0.5f * side * size, up * size, 0.0f}, {s, 0.0f, c}, {c, 0.0f, -s, 1.0f}, {0.5f + 0.5f * side, up}});
    }
  data.indices = {0, 2, 3, 0, 3, 1};
  return data;
}

// Returns the scene that draws turning_quad(6).
RenderScene turning_scene() {
  RenderScene scene;
  scene.camera.eye = {0.0f, 3.0f, 30.0f};
  scene.camera.target = {0.0f, 3.0f, 0.0f};
  scene.camera.up = {0.0f, 1.0f, 0.0f};
  scene.uv_scale = 1.0f;
  scene.lights[0].direction = glm::normalize(glm::vec3(0.3f, 0.2f, 1.0f));
  scene.brdf.exponent = 60.0f;
  scene.brdf.diffuse = glm::vec3(0.0f);  // the edges of the strip reflect no light
  return scene;
}

class EvaluationsTest : public testing::TestWithParam<ContextBackend> {
 protected:
  void SetUp() override {
    context_ = make_test_context(GetParam());
    mesh_ = std::make_unique<Mesh>(context_->functions(), make_quad(60.0f));
    renderer_ = std::make_unique<Renderer>(context_->functions(), 80, 60);
  }

  FloatImage drawn(const Material& material, RenderScene scene, const TextureFilter& filter) {
    scene.filter = filter;
    return renderer_->draw_once(*mesh_, material, scene);
  }
  FloatImage reference(const NormalImage& image, const RenderScene& scene) {
    const NormalMaterial material(context_->functions(), image, NormalMaterial::Sampling::kNearest, 1.0f);
    return renderer_->draw_reference(*mesh_, material, scene, {256}).image;
  }
  static double error_of(const FloatImage& picture, const FloatImage& exact) {
    return picture_error(picture, exact).relative_l1;
  }

  std::unique_ptr<HeadlessContext> context_;
  std::unique_ptr<Mesh> mesh_;
  std::unique_ptr<Renderer> renderer_;
};

TEST_P(EvaluationsTest, AFlatMapIsTheSameByAnyBudget) {
  const TestMap map = make_flat_map(16);
  const GlFunctions& gl = context_->functions();
  std::vector<std::unique_ptr<Material>> materials;
  materials.push_back(std::make_unique<MovmfMaterial>(gl, map.mipmap, 1.0f));
  materials.push_back(std::make_unique<MovmfMaterial>(gl, as_gaussians(map.mipmap), 1.0f));
  materials.push_back(std::make_unique<MomentMaterial>(gl, make_moments(map.image, StorageEncoding::kFloat), 1.0f));
  materials.push_back(std::make_unique<ShMaterial>(gl, make_harmonics(map.image, 4, StorageEncoding::kFloat), 1.0f));
  RenderScene scene;
  scene.brdf.exponent = 20.0f;
  for (const auto& material : materials) {
    const FloatImage usual = drawn(*material, scene, filter_of(0));
    // Each filter needs its own program, which takes drivers a second to compile.
    for (const TextureFilter& filter : {filter_of(2), filter_of(16, true)})
      EXPECT_LT(error_of(drawn(*material, scene, filter), usual), 2e-3)
          << material->name() << ", " << filter.evaluations;
  }
}

// More points lower the error of averaged normals. Lobes of steep bumps do not need more points.
TEST_P(EvaluationsTest, PointsAreNearer) {
  const TestMap map = make_noise_map(64, 0.3f, WrapMode::kPeriodic);
  RenderScene scene = distant_scene();
  scene.uv_scale = 10.0f;
  scene.brdf.exponent = 100.0f;
  NormalMaterial averages(context_->functions(), map.image, NormalMaterial::Sampling::kMipmapped, 1.0f);
  averages.set_baseline(Baseline::kMip);
  const FloatImage exact = reference(map.image, scene);
  double before = error_of(drawn(averages, scene, filter_of(1)), exact);
  for (const int points : {4, 16}) {
    const double error = error_of(drawn(averages, scene, filter_of(points)), exact);
    EXPECT_LT(error, 0.9 * before) << points;
    before = error;
  }
}

// Two tilts are two lobes. A budget of two shades both; a budget of one adds them up to one lobe.
TEST_P(EvaluationsTest, NormalsThatScatterAreShadedAsLobes) {
  const TestMap map = make_two_tilt_map(16, 25.0, StorageEncoding::kFloat, false);
  RenderScene scene = distant_scene();
  const MovmfMaterial lobes(context_->functions(), map.mipmap, 1.0f);
  const FloatImage usual = drawn(lobes, scene, filter_of(0));
  EXPECT_LT(error_of(drawn(lobes, scene, filter_of(2)), usual), 1e-3);
  EXPECT_GT(error_of(drawn(lobes, scene, filter_of(1)), usual), 0.05);
  // Two tilts of half a degree are nearly the same: 1 - |r| is 4e-5. If evaluations are spent on points, each point has
  // one lobe, and the picture hardly changes.
  const TestMap alike = make_two_tilt_map(16, 0.5, StorageEncoding::kFloat, false);
  const MovmfMaterial narrow(context_->functions(), alike.mipmap, 1.0f);
  EXPECT_LT(error_of(drawn(narrow, scene, filter_of(2)), drawn(narrow, scene, filter_of(0))), 0.01);
}

// Four tilts form two pairs, and the tilts of a pair are 2 degrees apart. A budget of two evaluations adds up each
// pair, which changes the picture very little.
TEST_P(EvaluationsTest, LobesThatAreAlikeAreAddedUpFirst) {
  TestMap map = make_two_tilt_map(16, 25.0, StorageEncoding::kFloat, false);
  for (MovmfLevel& level : map.mipmap.levels) {
    const auto turned = [](const std::vector<glm::vec4>& lobes, float by) {
      std::vector<glm::vec4> to = lobes;
      for (glm::vec4& lobe : to)
        lobe = 0.5f * glm::vec4(lobe.x, lobe.y * std::cos(by) - lobe.z * std::sin(by),
                                lobe.y * std::sin(by) + lobe.z * std::cos(by), lobe.w);
      return to;
    };
    const auto first = level.lobes[0], second = level.lobes[1];
    level.lobes = {turned(first, 0.02f), turned(second, 0.02f), turned(first, -0.02f), turned(second, -0.02f)};
  }
  RenderScene scene = distant_scene();
  const MovmfMaterial lobes(context_->functions(), map.mipmap, 1.0f);
  const FloatImage usual = drawn(lobes, scene, filter_of(0));
  EXPECT_LT(error_of(drawn(lobes, scene, filter_of(2)), usual), 0.02);
  EXPECT_LT(error_of(drawn(lobes, scene, filter_of(kEvaluationsOfLobes)), usual), 1e-6);
}

// Draws averaged normals, Toksvig's rule and LEAN on a mesh whose normals turn by 120 degrees within a few pixels.
// Adding the variance of the mesh's normals lowers their errors.
TEST_P(EvaluationsTest, WhatHasNoLobesWidensWhereTheMeshTurns) {
  const TestMap map = make_flat_map(16);
  mesh_ = std::make_unique<Mesh>(context_->functions(), turning_quad(6.0f));
  const RenderScene scene = turning_scene();
  NormalMaterial averages(context_->functions(), map.image, NormalMaterial::Sampling::kMipmapped, 1.0f);
  const FloatImage exact = reference(map.image, scene);
  for (const Baseline baseline : {Baseline::kMip, Baseline::kToksvig, Baseline::kLean, Baseline::kLeanJacobian}) {
    averages.set_baseline(baseline);
    const double without = error_of(drawn(averages, scene, filter_of(0)), exact);
    EXPECT_LT(error_of(drawn(averages, scene, filter_of(0, true)), exact), 0.8 * without) << static_cast<int>(baseline);
  }
  // A quarter of a pixel has a quarter of the variance.
  averages.set_baseline(Baseline::kMip);
  const double without = error_of(drawn(averages, scene, filter_of(4)), exact);
  EXPECT_LT(error_of(drawn(averages, scene, filter_of(4, true)), exact), 0.8 * without);
}

// Where the normals of the mesh turn within a pixel, the lobes of each point use the frame of that point.
TEST_P(EvaluationsTest, LobesTurnWithTheMesh) {
  const TestMap map = make_flat_map(16);
  mesh_ = std::make_unique<Mesh>(context_->functions(), turning_quad(6.0f));
  const RenderScene scene = turning_scene();
  const MovmfMaterial lobes(context_->functions(), map.mipmap, 1.0f);
  const FloatImage exact = reference(map.image, scene);
  const double once = error_of(drawn(lobes, scene, filter_of(1)), exact);
  EXPECT_LT(error_of(drawn(lobes, scene, filter_of(1, true)), exact), 0.8 * once);
}

// A point's colours are the mean over the same places as its lobes. Texels of this map are black or white, so the
// colours of only one place would be far from those of the pixel.
float speckle(int x, int y) { return (x * 7 + y * 13 + x * y) % 5 < 2 ? 1.0f : 0.0f; }
std::vector<glm::vec3> speckles() {
  std::vector<glm::vec3> made;
  for (int i = 0; i < 64 * 64; ++i) made.emplace_back(speckle(i % 64, i / 64));
  return made;
}
RenderScene matt_distant_scene() {
  RenderScene scene = distant_scene();
  scene.brdf.diffuse = glm::vec3(1.0f);
  scene.brdf.specular = glm::vec3(0.0f);
  return scene;
}

TEST_P(EvaluationsTest, ColoursAreReadWhereLobesAre) {
  TestMap map = make_two_tilt_map(64, 0.0, StorageEncoding::kFloat, true);
  map.image.albedo = speckles();
  for (std::size_t l = 0; l < map.mipmap.levels.size(); ++l) {
    MovmfLevel& level = map.mipmap.levels[l];
    const int side = 64 >> l, block = 1 << l;
    for (int i = 0; i < side * side; ++i) {
      float sum = 0.0f;
      for (int k = 0; k < block * block; ++k)
        sum += speckle(i % side * block + k % block, i / side * block + k / block);
      const float mean = sum / static_cast<float>(block * block);
      const auto at = static_cast<std::size_t>(i);
      for (std::size_t j = 0; j < 2; ++j) level.colours[j][at] = glm::vec3(level.lobes[j][at].w * mean);
    }
  }
  const RenderScene scene = matt_distant_scene();
  const MovmfMaterial lobes(context_->functions(), map.mipmap, 1.0f);
  const FloatImage exact = reference(map.image, scene);
  const double usual = error_of(drawn(lobes, scene, filter_of(1)), exact);
  EXPECT_LT(error_of(drawn(lobes, scene, filter_of(1, true)), exact), 1.1 * usual);
}

TEST_P(EvaluationsTest, SharedColoursAreReadWhereLobesAre) {
  TestMap map = make_two_tilt_map(64, 0.0, StorageEncoding::kFloat, false);
  map.image.albedo = speckles();
  TexelPlane plane{64, 64, {}};
  for (const glm::vec3& colour : map.image.albedo) plane.texels.emplace_back(colour, 1.0f);
  MovmfMaterial lobes(context_->functions(), map.mipmap, 1.0f);
  lobes.set_mean_colours(
      upload_mips(context_->functions(), "colours", plane, 7, {WrapMode::kPeriodic, WrapMode::kPeriodic, true, 1.0f}));
  const RenderScene scene = matt_distant_scene();
  const FloatImage exact = reference(map.image, scene);
  const double usual = error_of(drawn(lobes, scene, filter_of(1)), exact);
  EXPECT_LT(error_of(drawn(lobes, scene, filter_of(1, true)), exact), 1.1 * usual);
}

INSTANTIATE_TEST_SUITE_P(Backends, EvaluationsTest, testing::ValuesIn(test_backends()),
                         [](const auto& test) { return std::string(context_backend_name(test.param)); });

}  // namespace
}  // namespace multum::gl
