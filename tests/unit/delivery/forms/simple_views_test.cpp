// SPDX-License-Identifier: Apache-2.0
// Tests pixels of planes and spheres. They must cover the stated number of texels, and their derivatives must agree
// with samples.
#include "host/delivery/forms/simple_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <set>

namespace multum {
namespace {

constexpr int kWidth = 256, kHeight = 128;

TEST(SimpleViewsTest, PixelsAreAsLargeAsTheySay) {
  std::map<std::string, std::set<double>> distances;
  for (const ModelPicture& picture : simple_views(kWidth, kHeight, 50)) {
    distances[picture.shape].insert(picture.distance);
    ASSERT_EQ(picture.pixels.size(), 1u);
    const ModelPixel& pixel = picture.pixels[0];
    const glm::dvec3 towards_eye = glm::normalize(picture.eye - pixel.middle.position);
    const double facing = glm::dot(pixel.middle.normal, towards_eye);
    ASSERT_GT(facing, 0.2);
    // Computes the area of a pixel on the surface, as seen from the eye, in texels.
    const double area = glm::length(glm::cross(pixel.along_x.position, pixel.along_y.position)) * facing;
    EXPECT_GE(std::sqrt(area), 0.7 * picture.distance);
    EXPECT_LE(std::sqrt(area), 1.5 * picture.distance);
    // Computes the area of a pixel on the map. On a sphere, the columns of the map are denser towards the poles.
    const glm::dvec2 size(kWidth, kHeight), x = pixel.along_x.place * size, y = pixel.along_y.place * size;
    const double latitude = picture.shape == "sphere" ? std::asin(pixel.middle.normal.y) : 0.0;
    EXPECT_NEAR(std::abs(x.x * y.y - x.y * y.x) * facing * std::cos(latitude), area,
                (picture.shape == "sphere" ? 0.3 : 1e-6) * area);
    ASSERT_EQ(pixel.sample_count(), 64u);
    glm::dvec2 mean(0.0);
    for (std::size_t i = 0; i < pixel.sample_count(); ++i) mean += pixel.sample(i).place / 64.0;
    EXPECT_LT(glm::length((mean - pixel.middle.place) * size), 0.2 * (glm::length(x) + glm::length(y)));
    EXPECT_NEAR(glm::length(pixel.middle.tangent), 1.0, 1e-9);
    EXPECT_NEAR(glm::dot(pixel.middle.normal, glm::cross(pixel.middle.tangent, pixel.middle.bitangent)), 1.0, 1e-9);
  }
  const std::set<double> expected = {1.0, 2.0, 4.0, 8.0, 16.0};
  EXPECT_EQ(distances, (std::map<std::string, std::set<double>>{
                           {"plane", expected}, {"tilted plane", expected}, {"sphere", expected}}));
}

TEST(SimpleViewsTest, NormalsTurnOnSpheresAlone) {
  for (const ModelPicture& picture : simple_views(kWidth, kHeight, 20)) {
    const double turned = glm::length(picture.pixels[0].along_x.normal);
    EXPECT_EQ(turned > 0.3 * picture.distance * 3.14159 / kWidth, picture.shape == "sphere") << turned;
  }
}

TEST(SimpleViewsTest, SamplesOfLargeSpheresAreOnTheSphere) {
  constexpr double kPixel = 8.0;                                 // texels
  for (const double radius : {900.0 * kPixel, 3000.0 * kPixel})  // one is curved within a pixel, one is flat
    for (const ModelPicture& picture :
         shape_views(kWidth, kHeight, {{{kPixel, kPixel}}, {kSphere}, radius, 0.0, 50, 8})) {
      const ModelPixel& pixel = picture.pixels.at(0);
      ASSERT_EQ(pixel.sample_count(), 64u);
      for (std::size_t i = 0; i < pixel.sample_count(); ++i) {
        const SurfacePoint sample = pixel.sample(i);
        EXPECT_NEAR(glm::length(sample.position), radius, 0.001 * kPixel);
        EXPECT_LT(glm::length(sample.normal - sample.position / radius), 1e-5);
        EXPECT_NEAR(glm::length(sample.tangent), 1.0, 1e-5);
      }
    }
}

TEST(SimpleViewsTest, ATinyMapHasNone) { EXPECT_TRUE(simple_views(8, 8, 20).empty()); }

}  // namespace
}  // namespace multum
