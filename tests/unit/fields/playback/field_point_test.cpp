// SPDX-License-Identifier: Apache-2.0
// Tests points between samples: the shares of the samples, rotating cameras, and objects whose textures keep their
// sizes.
#include "host/fields/playback/field_point.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "tests/unit/fields/playback/small_packed_field.h"

namespace multum {
namespace {

void expect_near(const glm::dmat4& a, const glm::dmat4& b, double tolerance) {
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) EXPECT_NEAR(a[c][r], b[c][r], tolerance) << c << "," << r;
}

TEST(FieldPoint, NearestAndLinearShares) {
  const SampleGrid grid = testing::small_description().grid;  // 6 views, 4 lights
  EXPECT_EQ(clamped_point(grid, {-3.0, 9.0}), (std::vector<double>{0.0, 3.0}));
  const auto at = [](std::size_t view, std::size_t light) { return 4 * view + light; };
  EXPECT_EQ(nearest_sample(grid, {2.4, 1.5}), at(2, 2));
  const auto nearest = sample_shares(grid, {2.4, 1.75}, false);
  ASSERT_EQ(nearest.size(), 1u);
  EXPECT_EQ(nearest[0].sample, at(2, 2));
  const auto mixed = sample_shares(grid, {2.25, 1.75}, true);
  ASSERT_EQ(mixed.size(), 4u);
  EXPECT_EQ(mixed[0].sample, at(2, 2));
  float sum = 0.0f;
  double view = 0.0, light = 0.0;
  for (const SampleShare& share : mixed) {
    sum += share.share;
    view += static_cast<double>(share.share) * static_cast<double>(share.sample / 4);
    light += static_cast<double>(share.share) * static_cast<double>(share.sample % 4);
  }
  EXPECT_NEAR(sum, 1.0f, 1e-6f);
  EXPECT_NEAR(view, 2.25, 1e-6);
  EXPECT_NEAR(light, 1.75, 1e-6);
  EXPECT_EQ(sample_shares(grid, {5.0, 3.0}, true).size(), 1u);
}

TEST(FieldPoint, CamerasTurnAboutTheirEye) {
  // A camera circles an object and zooms. Halfway, it has turned by half of the angle and looks from a point in
  // between.
  const auto camera = [](double degrees, double fov) {
    const glm::dmat4 turned = glm::rotate(glm::dmat4(1.0), glm::radians(degrees), glm::dvec3(0.0, 1.0, 0.0));
    const glm::dmat4 view = glm::translate(turned, glm::dvec3(-3.0, -1.0, 2.0));
    glm::dmat4 projection = glm::perspective(glm::radians(fov), 4.0 / 3.0, 0.1, 100.0);
    projection[2][0] = 0.2;  // off centre
    return projection * view;
  };
  expect_near(camera_between(camera(10.0, 40.0), camera(50.0, 40.0), 0.5), camera(30.0, 40.0), 1e-9);
  expect_near(camera_between(camera(10.0, 40.0), camera(50.0, 40.0), 0.25), camera(20.0, 40.0), 1e-9);
  expect_near(camera_between(camera(10.0, 40.0), camera(50.0, 60.0), 0.0), camera(10.0, 40.0), 1e-9);
  expect_near(camera_between(camera(10.0, 40.0), camera(50.0, 60.0), 1.0), camera(50.0, 60.0), 1e-9);
  // The eye moves in a straight line.
  const auto from = glm::lookAt(glm::dvec3(0, 0, 5), glm::dvec3(0), glm::dvec3(0, 1, 0));
  const auto to = glm::lookAt(glm::dvec3(4, 0, 3), glm::dvec3(0), glm::dvec3(0, 1, 0));
  const glm::dmat4 lens = glm::perspective(0.7, 1.0, 0.1, 50.0);
  const glm::dmat4 half = glm::inverse(lens) * camera_between(lens * from, lens * to, 0.5);
  const glm::dvec4 eye = glm::inverse(half) * glm::dvec4(0, 0, 0, 1);
  EXPECT_NEAR(eye.x, 2.0, 1e-6);
  EXPECT_NEAR(eye.z, 4.0, 1e-6);
  // Matrices that are not camera matrices are interpolated linearly.
  expect_near(camera_between(glm::dmat4(1.0), glm::dmat4(3.0), 0.5), glm::dmat4(2.0), 1e-12);
}

TEST(FieldPoint, PlacesTurnAndKeepTheirSizes) {
  const auto place = [](double degrees, double size, double x) {
    const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), glm::dvec3(x, 1.0, 0.0));
    return glm::scale(glm::rotate(moved, glm::radians(degrees), glm::dvec3(0.0, 0.0, 1.0)),
                      glm::dvec3(size, 2.0, -1.0));
  };
  expect_near(place_between(place(0.0, 1.0, 0.0), place(90.0, 3.0, 4.0), 0.5), place(45.0, 2.0, 2.0), 1e-9);
}

TEST(FieldPoint, MatricesAtSamplesAreTheirOwn) {
  const SampleGrid grid = testing::small_description().grid;
  const auto of_sample = [](std::size_t sample) {
    glm::dmat4 m(1.0);
    m[3] = glm::dvec4(static_cast<double>(sample / 4), 0.1 * static_cast<double>(sample % 4), 0.0, 1.0);
    return m;
  };
  EXPECT_EQ(matrix_at(grid, {3.0, 2.0}, of_sample, place_between), of_sample(14));
  const glm::dmat4 between = matrix_at(grid, {3.5, 1.25}, of_sample, place_between);
  EXPECT_NEAR(between[3][0], 3.5, 1e-12);
  EXPECT_NEAR(between[3][1], 0.125, 1e-12);
}

}  // namespace
}  // namespace multum
