// SPDX-License-Identifier: Apache-2.0
// Compares kernels/mip_box.cl and kernels/reflectance_pyramid.cl with double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "host/bakes/pyramid/reflectance_bake.h"
#include "host/formats/asset/pyramid/pyramid_sample.h"
#include "host/foundation/base/error.h"
#include "host/lab/reference/reflectance.h"
#include "tests/kernels/em_harness.h"

namespace multum {
namespace {

using testing::test_device;

struct Size {
  int width, height;
};

void PrintTo(const Size& size, std::ostream* out) { *out << size.width << " x " << size.height; }

std::vector<float> random_planes(const BoxMap& map, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<float> planes(static_cast<std::size_t>(map.plane_count * map.width * map.height));
  for (float& v : planes) v = 2.0f * static_cast<float>(random() >> 8) * 0x1p-24f - 0.5f;
  return planes;
}

// Averages the texels of the finest level that texel (x, y) of a level of w x h covers. The weights are the covered
// areas.
double covered_mean(const std::vector<float>& planes, const BoxMap& map, int plane, int w, int h, int x, int y) {
  const double x0 = static_cast<double>(x) * map.width / w, x1 = static_cast<double>(x + 1) * map.width / w;
  const double y0 = static_cast<double>(y) * map.height / h, y1 = static_cast<double>(y + 1) * map.height / h;
  double sum = 0.0;
  for (int j = static_cast<int>(y0); j < map.height && j < y1; ++j)
    for (int i = static_cast<int>(x0); i < map.width && i < x1; ++i) {
      const double share = (std::min(x1, i + 1.0) - std::max(x0, static_cast<double>(i))) *
                           (std::min(y1, j + 1.0) - std::max(y0, static_cast<double>(j)));
      const auto at = static_cast<std::size_t>((plane * map.height + j) * map.width + i);
      sum += share * static_cast<double>(planes[at]);
    }
  return sum / ((x1 - x0) * (y1 - y0));
}

class MipBoxTest : public ::testing::TestWithParam<Size> {};
INSTANTIATE_TEST_SUITE_P(Sizes, MipBoxTest,
                         ::testing::Values(Size{1, 1}, Size{2, 2}, Size{1, 17}, Size{33, 1}, Size{16, 64}, Size{11, 7},
                                           Size{63, 65}, Size{37, 100}));

// The kernel uses pairwise sums along a row and compensated sums over the rows, so the error is a few roundings of
// numbers up to 1.5.
TEST_P(MipBoxTest, EveryTexelIsTheMeanOfWhatItCovers) {
  for (const int plane_count : {1, 3}) {
    const BoxMap map = {GetParam().width, GetParam().height, plane_count, 0};
    const std::vector<float> planes = random_planes(map, 41);
    const Pyramid pyramid = box_pyramid(test_device(), map, planes.data(), 1u << 24);
    ASSERT_EQ(static_cast<int>(pyramid.levels.size()), mip_level_count(map.width, map.height));
    for (const PyramidLevel& level : pyramid.levels) {
      ASSERT_EQ(level.values.size(), static_cast<std::size_t>(plane_count * level.width * level.height));
      for (int y = 0, i = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x)
          for (int c = 0; c < plane_count; ++c, ++i)
            ASSERT_NEAR(static_cast<double>(level.values[static_cast<std::size_t>(i)]),
                        covered_mean(planes, map, c, level.width, level.height, x, y), 1e-6)
                << level.width << " x " << level.height << ", texel (" << x << ", " << y << ")";
    }
  }
}

TEST_P(MipBoxTest, BandsOfAnyHeightAreTheSameBytes) {
  const BoxMap map = {GetParam().width, GetParam().height, 3, 0};
  const std::vector<float> planes = random_planes(map, 43);
  const Pyramid whole = box_pyramid(test_device(), map, planes.data(), 1u << 24);
  int bakes = 0;
  for (std::uint64_t bytes = 1024; bytes < (1u << 20); bytes *= 2) {
    try {
      const Pyramid banded = box_pyramid(test_device(), map, planes.data(), bytes);
      for (std::size_t l = 0; l < whole.levels.size(); ++l) EXPECT_EQ(banded.levels[l].values, whole.levels[l].values);
      ++bakes;
    } catch (const Error& error) {  // this memory is too small for a single row
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
    }
  }
  EXPECT_GT(bakes, 3);
}

// Tests the longest possible column. If its 32768 numbers near 0.1 were simply added in single precision, the relative
// error would be about 1e-4.
TEST(MipBoxHardTest, LongColumnsKeepTheirDigits) {
  const BoxMap map = {1, 32768, 1, 0};
  std::vector<float> column;
  double sum = 0.0;
  for (int i = 0; i < map.height; ++i) {
    column.push_back(0.1f + 1e-6f * static_cast<float>(i % 7));
    sum += static_cast<double>(column.back());
  }
  const Pyramid pyramid = box_pyramid(test_device(), map, column.data(), 1u << 24);
  EXPECT_NEAR(static_cast<double>(pyramid.levels.back().values[0]), sum / map.height, 1e-8);
}

// Tests zero light, and lights behind the surface, in the viewer's direction and opposite to it. The results must be
// finite and not negative.
TEST(ReflectanceKernelTest, LightsFromAnywhere) {
  ReflectanceJob job;
  job.size = 16;
  job.exponent = 1e5f;
  job.viewer = {0.0, 0.0, 1.0};
  for (const glm::dvec3 direction :
       {glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(1e-9, 0, -1)})
    for (const double light : {0.0, 1e-20, 1e6}) job.lights.push_back({direction, glm::dvec3(light)});
  const Pyramid pyramid = reflectance_pyramid(job, test_device());
  for (const PyramidLevel& level : pyramid.levels)
    for (const float value : level.values) {
      EXPECT_TRUE(std::isfinite(value));
      EXPECT_GE(value, 0.0f);
    }
}

ReflectanceJob job_of(float exponent, int size) {
  ReflectanceJob job;
  job.size = size;
  job.sample_side = 2;
  job.exponent = exponent;
  job.viewer = {0.3, -0.4, 0.7};
  job.diffuse = {0.5, 0.3, 0.1};
  job.specular = {0.1, 0.2, 0.3};
  job.lights = {
      {{0.3, 0.8, 0.5}, glm::dvec3(3.0)}, {{-2.0, 0.1, 0.4}, {1.0, 0.5, 0.2}}, {{0.0, 0.0, -1.0}, {0.2, 0.2, 0.9}}};
  return job;
}

std::vector<reference::DistantLight> reference_lights(const ReflectanceJob& job) {
  std::vector<reference::DistantLight> lights;
  for (const ReflectanceLight& light : job.lights)
    lights.push_back({glm::normalize(light.direction), light.irradiance});
  return lights;
}

// Compares with the same normals in double precision. The remaining error is the rounding error of the cosine times the
// exponent s. At the foot of a lobe, this error is 1.2e-7 s times the value, which for every s is about 1e-6 of the
// peak of the lobe.
TEST(ReflectanceKernelTest, TexelsEqualTheReference) {
  for (const float exponent : {1.0f, 30.0f, 1000.0f, 1e5f}) {
    const ReflectanceJob job = job_of(exponent, 37);
    const Pyramid pyramid = reflectance_pyramid(job, test_device());
    const ReflectanceFrame frame = reflectance_frame(job.viewer, job.up);
    const reference::PhongSurface surface = {static_cast<double>(exponent), job.diffuse, job.specular};
    const double peak = 3.0 * (0.5 / M_PI + 0.3 * (static_cast<double>(exponent) + 1.0) / (2.0 * M_PI));
    double worst = 0.0, largest = 0.0;
    for (int y = 0; y < job.size; ++y)
      for (int x = 0; x < job.size; ++x) {
        glm::dvec3 mean(0.0);
        for (int j = 0; j < 2; ++j)
          for (int i = 0; i < 2; ++i) {
            const glm::dvec2 place((x + 0.25 + 0.5 * i) / job.size, (y + 0.25 + 0.5 * j) / job.size);
            mean += 0.25 * reference::phong_radiance(reflectance_normal(frame, place), frame.viewer,
                                                     reference_lights(job), surface);
          }
        for (int c = 0; c < 3; ++c) {
          const auto at = static_cast<std::size_t>(3 * (y * job.size + x) + c);
          worst = std::max(worst, std::abs(static_cast<double>(pyramid.levels[0].values[at]) - mean[c]));
          largest = std::max(largest, mean[c]);
        }
      }
    EXPECT_LT(worst, 3e-6 * peak) << "s = " << exponent;
    EXPECT_GT(largest, 0.02) << "there is light";
  }
}

// Each level averages over equal solid angles, so the highlight keeps its energy, however sharp it is.
TEST(ReflectanceKernelTest, EnergyStays) {
  ReflectanceJob job = job_of(1000.0f, 128);
  job.lights.resize(1);
  job.diffuse = glm::dvec3(0.0);
  const Pyramid pyramid = reflectance_pyramid(job, test_device());
  const ReflectanceFrame frame = reflectance_frame(job.viewer, job.up);
  // Integrates over normals by quadrature around the half vector.
  const glm::dvec3 l = glm::normalize(job.lights[0].direction), h = glm::normalize(l + frame.viewer);
  const reference::PhongSurface surface = {1000.0, job.diffuse, job.specular};
  const ReflectanceFrame about = reflectance_frame(h, {0.0, 1.0, 0.0});
  double expected = 0.0;
  constexpr int kSteps = 400;
  for (int j = 0; j < kSteps; ++j)
    for (int i = 0; i < kSteps; ++i) {
      const glm::dvec2 place((i + 0.5) / kSteps, (j + 0.5) / kSteps);
      expected +=
          8.0 / (kSteps * kSteps) *
          reference::phong_radiance(reflectance_normal(about, place), frame.viewer, {{l, glm::dvec3(3.0)}}, surface)[0];
    }
  for (std::size_t l2 = 0; l2 < pyramid.levels.size(); ++l2) {
    double sum = 0.0;
    const PyramidLevel& level = pyramid.levels[l2];
    for (std::size_t i = 0; i < level.values.size(); i += 3) sum += static_cast<double>(level.values[i]);
    EXPECT_NEAR(sum * 8.0 / (level.width * level.height), expected, 2e-3 * expected) << "level " << l2;
  }
}

TEST(ReflectanceMappingTest, PlacesAndNormalsAreEachOthersInverse) {
  const ReflectanceFrame frame = reflectance_frame({0.2, 0.5, -0.8}, {0.0, 1.0, 0.0});
  std::mt19937 random(5);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec2 place(static_cast<double>(random()) * 0x1p-32, static_cast<double>(random()) * 0x1p-32);
    const glm::dvec3 normal = reflectance_normal(frame, place);
    EXPECT_NEAR(glm::length(normal), 1.0, 1e-12);
    const glm::dvec2 back = reflectance_place(frame, normal);
    EXPECT_NEAR(back.x, place.x, 1e-9);
    EXPECT_NEAR(back.y, place.y, 1e-9);
  }
  EXPECT_NEAR(glm::distance(reflectance_place(frame, frame.viewer), glm::dvec2(0.5)), 0.0, 1e-12);
  EXPECT_LT(
      glm::distance(parse_reflectance_frame("{\"frame\":" + reflectance_frame_json(frame) + "}", "x").up, frame.up),
      1e-15);
  EXPECT_THROW(parse_reflectance_frame("{}", "x"), Error);
}

// Every texel has the solid angle 8 / size^2. The test computes it from the spherical quadrilateral of the texel's
// corners.
TEST(ReflectanceMappingTest, AreasAreEqual) {
  const ReflectanceFrame frame;
  const auto normal = [&](int x, int y) { return reflectance_normal(frame, glm::dvec2(x / 64.0, y / 64.0)); };
  for (const auto& [x, y] : std::vector<std::pair<int, int>>{{32, 32}, {10, 31}, {2, 40}, {5, 5}}) {
    const glm::dvec3 a = normal(x, y), b = normal(x + 1, y), c = normal(x + 1, y + 1), d = normal(x, y + 1);
    const double area = 0.5 * glm::length(glm::cross(c - a, d - b));
    EXPECT_NEAR(area, 8.0 / 4096.0, 2e-3 * 8.0 / 4096.0) << x << ", " << y;
  }
}

// A white surface in a white sphere of light is white from every side: the irradiance E is pi L, and the radiance is
// k_d L.
TEST(EnvironmentLightsTest, AWhiteFurnace) {
  const EnvironmentMap white{64, 32, std::vector<glm::vec3>(64 * 32, glm::vec3(2.0f))};
  ReflectanceJob job = job_of(50.0f, 16);
  job.lights = environment_lights(white, 50.0f, 0.5f);
  job.diffuse = glm::dvec3(0.8);
  job.specular = glm::dvec3(0.0);
  const Pyramid pyramid = reflectance_pyramid(job, test_device());
  for (const float v : pyramid.levels[0].values) EXPECT_NEAR(v, 0.8f, 0.004f);
}

// A single bright texel shines from its own direction. The middle of the map is -Z, and the point a quarter of the
// width to the right is +X.
TEST(EnvironmentLightsTest, DirectionsAreTheMaps) {
  using Case = std::pair<int, glm::dvec3>;
  for (const auto& [column, direction] : {Case{32, {0, 0, -1}}, Case{48, {1, 0, 0}}}) {
    EnvironmentMap dot{64, 32, std::vector<glm::vec3>(64 * 32, glm::vec3(0.0f))};
    dot.texels[static_cast<std::size_t>(16 * 64 + column)] = glm::vec3(1.0f);
    const std::vector<ReflectanceLight> lights = environment_lights(dot, 1e4f, 1.0f);
    ASSERT_EQ(lights.size(), 1u);
    EXPECT_LT(glm::distance(lights[0].direction, direction), 0.1);
    EXPECT_NEAR(lights[0].irradiance.x, 2.0 * M_PI / 64 * M_PI / 32, 1e-4);
  }
}

Pyramid tiny(WrapMode wrap) {
  const BoxMap map = {4, 2, 1, 0};
  const std::vector<float> values = {0, 1, 2, 3, 4, 5, 6, 7};
  Pyramid pyramid = box_pyramid(test_device(), map, values.data(), 1u << 20);
  pyramid.header.map.wrap_s = pyramid.header.map.wrap_t = wrap;
  return pyramid;
}

TEST(PyramidSampleTest, BordersAreAsTheHeaderSays) {
  // Half a texel to the left of the first texel centre, the value is the mean of the first texel and its left
  // neighbour.
  EXPECT_NEAR(sample_level(tiny(WrapMode::kPeriodic), 0, 0.0, 0.25)[0], 1.5, 1e-12);
  EXPECT_NEAR(sample_level(tiny(WrapMode::kClamp), 0, 0.0, 0.25)[0], 0.0, 1e-12);
  EXPECT_NEAR(sample_level(tiny(WrapMode::kMirror), 0, 1.0, 0.25)[0], 3.0, 1e-12);
  EXPECT_NEAR(sample_level(tiny(WrapMode::kBlack), 0, 1.0, 0.25)[0], 1.5, 1e-12);
  EXPECT_NEAR(sample_level(tiny(WrapMode::kPeriodic), 0, 5.625, 0.25)[0], 2.0, 1e-12) << "far away";
}

TEST(PyramidSampleTest, LevelsAreMixedLinearly) {
  const Pyramid pyramid = tiny(WrapMode::kPeriodic);
  EXPECT_NEAR(sample_pyramid(pyramid, 0.125, 0.25, -3.0)[0], 0.0, 1e-12);
  EXPECT_NEAR(sample_pyramid(pyramid, 0.25, 0.5, 1.0)[0], 2.5, 1e-6) << "the mean of 0, 1, 4, 5";
  EXPECT_NEAR(sample_pyramid(pyramid, 0.25, 0.5, 1.25)[0], 0.75 * 2.5 + 0.25 * 3.5, 1e-6);
  EXPECT_NEAR(sample_pyramid(pyramid, 0.25, 0.5, 9.0)[0], 3.5, 1e-6);
  EXPECT_NEAR(mip_level_of({3.0, 4.0, 1.0, 0.0}), std::log2(5.0), 1e-12);
}

}  // namespace
}  // namespace multum
