// SPDX-License-Identifier: Apache-2.0
// Compares kernels/one_lobe.cl with double precision, and tests known properties of its results. The sizes of levels
// nest or do not nest, and bands have any height.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "host/delivery/export/axis_cut.h"
#include "host/delivery/export/facet_samples.h"
#include "host/delivery/export/one_lobe_fit.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/error.h"
#include "host/lab/reference/one_lobe.h"
#include "tests/fixtures/random_values.h"
#include "tests/fixtures/test_device.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::make_map;
using testing::random_map;
using testing::test_device;
using testing::uniform24;

double wide(float value) { return static_cast<double>(value); }

class Levels : public MaterialSink {
 public:
  void add_level(int level, int first_row, MaterialRows rows) override {
    if (levels.size() <= static_cast<std::size_t>(level)) levels.resize(static_cast<std::size_t>(level) + 1);
    MaterialRows& to = levels[static_cast<std::size_t>(level)];
    EXPECT_EQ(first_row, to.height) << "level " << level;
    to.width = rows.width;
    to.height += rows.height;
    to.normals.insert(to.normals.end(), rows.normals.begin(), rows.normals.end());
    to.roughness.insert(to.roughness.end(), rows.roughness.begin(), rows.roughness.end());
    to.anisotropy.insert(to.anisotropy.end(), rows.anisotropy.begin(), rows.anisotropy.end());
    to.occlusion.insert(to.occlusion.end(), rows.occlusion.begin(), rows.occlusion.end());
    to.metalness.insert(to.metalness.end(), rows.metalness.begin(), rows.metalness.end());
  }
  std::vector<MaterialRows> levels;
};

// Holds the other planes of a map: alpha^2, occlusion and metalness.
struct Material {
  std::vector<float> base_squared, occlusion, metalness;
};

std::vector<MaterialRows> fit(const NormalMap& map, const OneLobeSettings& settings, const Material* material = nullptr,
                              std::uint64_t memory_bytes = 1u << 30) {
  const PlaneStore normals = planes_of(map);
  std::optional<PlaneStore> planes;
  OneLobeInputs inputs;
  inputs.normals = &normals;
  inputs.memory_bytes = memory_bytes;
  inputs.threads = 2;
  if (material != nullptr) {
    planes.emplace(map.width, map.height,
                   std::array<const float*, 3>{material->base_squared.data(), material->occlusion.data(),
                                               material->metalness.data()});
    inputs.material = &*planes;
    inputs.has_roughness = inputs.has_occlusion = inputs.has_metalness = true;
  }
  Levels levels;
  fit_one_lobe(test_device(), inputs, settings, levels, nullptr);
  return std::move(levels.levels);
}

Material random_material(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Material material;
  for (int i = 0; i < width * height; ++i) {
    const double roughness = 0.1 + 0.9 * uniform24(random);
    material.base_squared.push_back(static_cast<float>(std::pow(roughness, 4.0)));
    material.occlusion.push_back(static_cast<float>(uniform24(random)));
    material.metalness.push_back(static_cast<float>(uniform24(random)));
  }
  return material;
}

// Decodes an exported texel as a renderer does. Returns alpha along the axis, alpha across the axis, and the axis in
// space.
reference::OneLobe lobe_of(const MaterialRows& level, std::size_t i) {
  reference::OneLobe lobe;
  lobe.normal = glm::dvec3(level.normals[i]);
  lobe.alpha_narrow = lobe.alpha_wide = wide(level.roughness[i]) * wide(level.roughness[i]);
  const glm::dvec3 x = glm::normalize(glm::dvec3(1.0, 0.0, 0.0) - lobe.normal.x * lobe.normal);
  lobe.axis = x;
  if (level.anisotropy.empty()) return lobe;
  const glm::dvec3 a(level.anisotropy[i]);
  lobe.alpha_wide += (1.0 - lobe.alpha_wide) * a.z * a.z;
  lobe.axis = a.x * x + a.y * glm::cross(lobe.normal, x);
  return lobe;
}

// EM in single precision and EM in double precision converge to the same result. Rounding, including that of sums of
// 1024 terms, changes each step by about 1e-6 of the width of the lobe. The rounder a lobe is, the less certain its
// axis is.
constexpr double kTolerance = 2e-4;

void expect_near_reference(const NormalMap& map, const Material* material, const OneLobeSettings& settings) {
  const std::vector<MaterialRows> levels = fit(map, settings, material);
  ASSERT_EQ(static_cast<int>(levels.size()), mip_level_count(map.width, map.height));
  const double alpha = settings.base_roughness * settings.base_roughness;
  reference::OneLobeTexel texel{&map,
                                {alpha * alpha},
                                0,
                                0,
                                0,
                                0,
                                settings.is_anisotropic,
                                settings.is_fast ? 0 : settings.iteration_count,
                                material != nullptr ? kAlphaMin : std::max(kAlphaMin, alpha)};
  if (material != nullptr) texel.base_squared.assign(material->base_squared.begin(), material->base_squared.end());
  for (int l = 1; l < static_cast<int>(levels.size()); ++l) {
    const MaterialRows& level = levels[static_cast<std::size_t>(l)];
    ASSERT_EQ(level.width, mip_level_size(map.width, l));
    ASSERT_EQ(level.height, mip_level_size(map.height, l));
    texel.width = level.width;
    texel.height = level.height;
    const int grid = sample_grid(l);
    const std::vector<glm::vec2> facets = facet_samples(grid);
    for (texel.y = 0; texel.y < level.height; ++texel.y)
      for (texel.x = 0; texel.x < level.width; ++texel.x) {
        const std::size_t i = static_cast<std::size_t>(texel.y) * static_cast<std::size_t>(level.width) +
                              static_cast<std::size_t>(texel.x);
        const reference::OneLobe expected = reference::fit_one_lobe(texel, facets, grid), found = lobe_of(level, i);
        const std::string where =
            "level " + std::to_string(l) + ", texel (" + std::to_string(texel.x) + ", " + std::to_string(texel.y) + ")";
        EXPECT_NEAR(glm::distance(found.normal, expected.normal), 0.0, kTolerance) << where;
        EXPECT_NEAR(found.alpha_narrow / expected.alpha_narrow, 1.0, 10.0 * kTolerance) << where;
        EXPECT_NEAR(found.alpha_wide / expected.alpha_wide, 1.0, 10.0 * kTolerance) << where;
        if (!settings.is_anisotropic || expected.alpha_wide < 1.05 * expected.alpha_narrow) continue;
        EXPECT_NEAR(std::abs(glm::dot(found.axis, expected.axis)), 1.0, 1e-3) << where;
      }
  }
}

struct Size {
  int width, height;
};

void PrintTo(const Size& size, std::ostream* out) { *out << size.width << " x " << size.height; }

class OneLobeTest : public ::testing::TestWithParam<Size> {};
INSTANTIATE_TEST_SUITE_P(Sizes, OneLobeTest,
                         ::testing::Values(Size{1, 1}, Size{2, 2}, Size{1, 17}, Size{33, 1}, Size{16, 64}, Size{11, 7},
                                           Size{3, 100}, Size{63, 65}));

TEST_P(OneLobeTest, RandomNormalsEqualTheReference) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 0.6, 17);
  const Material material = random_material(width, height, 18);
  for (const bool is_anisotropic : {false, true})
    for (const bool is_fast : {false, true}) {
      OneLobeSettings settings;
      settings.is_anisotropic = is_anisotropic;
      settings.is_fast = is_fast;
      settings.base_roughness = 0.3;
      expect_near_reference(map, nullptr, settings);
      expect_near_reference(map, &material, settings);
    }
}

// The bytes do not depend on the available memory or on how the work is divided into bands, lanes and copies.
TEST_P(OneLobeTest, BandsAndShapesAreTheSameBytes) {
  const auto [width, height] = GetParam();
  const NormalMap map = random_map(width, height, 0.3, 23);
  const Material material = random_material(width, height, 24);
  OneLobeSettings settings;
  settings.is_anisotropic = true;
  const std::vector<MaterialRows> whole = fit(map, settings, &material);
  const auto expect_same = [&](const std::vector<MaterialRows>& other) {
    ASSERT_EQ(other.size(), whole.size());
    for (std::size_t l = 0; l < whole.size(); ++l) {
      EXPECT_EQ(other[l].normals, whole[l].normals) << l;
      EXPECT_EQ(other[l].roughness, whole[l].roughness) << l;
      EXPECT_EQ(other[l].anisotropy, whole[l].anisotropy) << l;
      EXPECT_EQ(other[l].occlusion, whole[l].occlusion) << l;
      EXPECT_EQ(other[l].metalness, whole[l].metalness) << l;
    }
  };
  int fits = 0;
  for (std::uint64_t memory_bytes = 4096; memory_bytes < (1u << 22); memory_bytes *= 2) {
    std::vector<MaterialRows> levels;
    try {
      levels = fit(map, settings, &material, memory_bytes);
    } catch (const Error& error) {  // this memory is too small for a single row
      ASSERT_EQ(error.code(), ErrorCode::kUsage) << error.what();
      continue;
    }
    ++fits;
    expect_same(levels);
  }
  EXPECT_GT(fits, 3);
  const LaunchShape shape = test_device().shape();
  test_device().set_shape(LaunchShape::of_accelerator(test_device().info()));
  const std::vector<MaterialRows> scalar = fit(map, settings, &material);
  test_device().set_shape(shape);
  expect_same(scalar);
}

// A surface of one normal keeps its own roughness at every level, however it is tilted.
TEST(OneLobe, OneNormalKeepsItsRoughness) {
  for (const double slope : {0.0, 0.5, 20.0})
    for (const double roughness : {0.0, 0.1, 0.5, 1.0})
      for (const bool is_anisotropic : {false, true}) {
        const glm::dvec3 normal = glm::normalize(glm::dvec3(-slope, 0.3 * slope, 1.0));
        OneLobeSettings settings;
        settings.base_roughness = roughness;
        settings.is_anisotropic = is_anisotropic;
        const NormalMap map = make_map(13, 40, [&](int, int) { return normal; });
        for (const MaterialRows& level : fit(map, settings))
          for (std::size_t i = 0; i < level.normals.size(); ++i) {
            const reference::OneLobe lobe = lobe_of(level, i);
            const double alpha = std::max(kAlphaMin, roughness * roughness);
            EXPECT_NEAR(glm::distance(lobe.normal, normal), 0.0, 0.02 * alpha + 1e-6) << slope << ", " << roughness;
            EXPECT_NEAR(lobe.alpha_narrow / alpha, 1.0, 0.02) << slope << ", " << roughness;
            EXPECT_NEAR(lobe.alpha_wide / alpha, 1.0, is_anisotropic ? 0.06 : 0.02) << slope << ", " << roughness;
          }
      }
}

// The samples have a higher likelihood with the fitted lobe than with any lobe near it.
TEST(OneLobe, IsTheLikeliest) {
  const NormalMap map = random_map(16, 16, 0.7, 31);
  OneLobeSettings settings;
  settings.is_anisotropic = true;
  settings.base_roughness = 0.4;
  settings.iteration_count = 60;
  const std::vector<MaterialRows> levels = fit(map, settings);
  const reference::OneLobeTexel texel{&map, {std::pow(0.4, 4.0)}, 2, 2, 1, 0, true, 0, kAlphaMin};
  const int grid = sample_grid(3);
  const std::vector<glm::dvec2> slopes = reference::sampled_slopes(texel, facet_samples(grid), grid);
  const reference::OneLobe lobe = lobe_of(levels[3], 1);
  // Uses the tangent frame of the mean normal, to which the slopes refer.
  glm::dvec3 z(0.0);
  for (int y = 0; y < 8; ++y)
    for (int x = 8; x < 16; ++x) {
      const std::size_t i = static_cast<std::size_t>(y * 16 + x);
      z += glm::dvec3(wide(map.x[i]), wide(map.y[i]), wide(map.z[i]));
    }
  z = glm::normalize(z);
  const glm::dvec3 x = glm::normalize(glm::dvec3(1.0, 0.0, 0.0) - z.x * z), y = glm::cross(z, x);
  const glm::dvec2 mean = glm::dvec2(glm::dot(lobe.normal, x), glm::dot(lobe.normal, y)) / glm::dot(lobe.normal, z);
  const glm::dvec2 axis = glm::normalize(glm::dvec2(glm::dot(lobe.axis, x), glm::dot(lobe.axis, y)));
  const auto deviance = [&](double right, double up, double longer, double wider, double turned) {
    const glm::dvec2 a(std::cos(turned) * axis.x - std::sin(turned) * axis.y,
                       std::sin(turned) * axis.x + std::cos(turned) * axis.y),
        b(-a.y, a.x);
    const double along = 0.5 * std::pow(longer * lobe.alpha_wide, 2.0),
                 across = 0.5 * std::pow(wider * lobe.alpha_narrow, 2.0);
    return reference::t_deviance(slopes, mean + glm::dvec2(right, up),
                                 along * glm::outerProduct(a, a) + across * glm::outerProduct(b, b));
  };
  const double least = deviance(0.0, 0.0, 1.0, 1.0, 0.0);
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_GT(deviance(0.02 * sign, 0.0, 1.0, 1.0, 0.0), least);
    EXPECT_GT(deviance(0.0, 0.02 * sign, 1.0, 1.0, 0.0), least);
    EXPECT_GT(deviance(0.0, 0.0, 1.0 + 0.03 * sign, 1.0, 0.0), least);
    EXPECT_GT(deviance(0.0, 0.0, 1.0, 1.0 + 0.03 * sign, 0.0), least);
    EXPECT_GT(deviance(0.0, 0.0, 1.0, 1.0, 0.2 * sign), least);
  }
}

// In a map of grooves, the axis points across the grooves, which is the direction in which normals tilt. It has the
// same sign in the whole map.
TEST(OneLobe, GroovesHaveOneAxis) {
  for (const double degrees : {0.0, 40.0, 90.0, 135.0}) {
    const double angle = degrees * M_PI / 180.0;
    const NormalMap map = make_map(64, 64, [&](int x, int y) {
      const double tilt = 0.4 * std::sin(5.0 * (x * std::cos(angle) + y * std::sin(angle)));
      return glm::normalize(glm::dvec3(tilt * std::cos(angle), tilt * std::sin(angle), 1.0));
    });
    OneLobeSettings settings;
    settings.is_anisotropic = true;
    settings.base_roughness = 0.2;
    const std::vector<MaterialRows> levels = fit(map, settings);
    const glm::vec3 first = levels[6].anisotropy[0];
    EXPECT_GT(std::abs(wide(first.x) * std::cos(angle) + wide(first.y) * std::sin(angle)), 0.99) << degrees;
    EXPECT_GT(first.z, 0.3f) << degrees;
    for (std::size_t l = 2; l < levels.size(); ++l)
      for (const glm::vec3& axis : levels[l].anisotropy)
        EXPECT_GT(axis.x * first.x + axis.y * first.y, 0.0f) << degrees;
  }
}

TEST(OneLobe, Cancels) {
  const NormalMap map = random_map(64, 64, 0.3, 5);
  const PlaneStore normals = planes_of(map);
  OneLobeInputs inputs;
  inputs.normals = &normals;
  inputs.memory_bytes = 64u << 10;
  Levels levels;
  Progress progress([](const ProgressEvent& event) { return event.units_done == 0; });
  EXPECT_THROW(fit_one_lobe(test_device(), inputs, {}, levels, &progress), Cancelled);
  EXPECT_LT(levels.levels[0].height, 64);
  OneLobeSettings settings;
  settings.base_roughness = 1.5;
  EXPECT_THROW(fit_one_lobe(test_device(), inputs, settings, levels, nullptr), Error);
}

}  // namespace
}  // namespace multum
