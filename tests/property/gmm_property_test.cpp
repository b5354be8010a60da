// SPDX-License-Identifier: Apache-2.0
// Compares planar Gaussians with lobes as Han et al. 2007 do in figure 7. Gaussians are as accurate as lobes for
// upright normals, and less accurate for normals near the rim of the disc. There, a round bump on the sphere becomes a
// thin bump on the plane, and the edge of the disc cuts it off.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/movmf/movmf_bake.h"
#include "host/formats/asset/lobes/gmm_quantize.h"
#include "tests/fixtures/test_device.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::test_device;

// Makes two clusters of normals, each about six degrees wide, which are tilted by this angle to either side. No normal
// is below the horizon.
NormalMap tilted_map(double degrees) {
  std::mt19937 random(2007);
  const auto normal = [&] { return std::normal_distribution<double>(0.0, 0.1)(random); };
  return testing::make_map(64, 64, [&](int, int) {
    const double tilt = degrees * M_PI / 180.0 + normal(), turn = normal(), side = random() % 2 == 0 ? 1.0 : -1.0;
    glm::dvec3 n(side * std::sin(tilt), turn, std::cos(tilt));
    n.z = std::abs(n.z);
    return glm::normalize(n);
  });
}

// Returns directions that are spread evenly over the upper hemisphere, in a golden-angle spiral.
std::vector<glm::dvec3> hemisphere(int count) {
  std::vector<glm::dvec3> directions;
  for (int i = 0; i < count; ++i) {
    const double z = (i + 0.5) / count, phi = i * M_PI * (3.0 - std::sqrt(5.0)), side = std::sqrt(1.0 - z * z);
    directions.emplace_back(side * std::cos(phi), side * std::sin(phi), z);
  }
  return directions;
}

// Returns the mean relative L1 error for each BRDF. The mean is over half vectors in all directions and over the levels
// with at most 16 x 16 texels.
std::map<std::string, double> errors_of(const NormalMap& map, Representation representation) {
  MovmfSettings settings;
  settings.representation = representation;
  settings.lobe_count = 2;
  settings.search_start = false;  // any initial lobes find two clusters
  FitReport report;
  MovmfMipmap mipmap = bake_movmf(test_device(), map, nullptr, settings, report, nullptr);
  EXPECT_EQ(report.nonfinite, 0u);
  quantize_movmf(mipmap, 1);
  AccuracySettings accuracy;
  accuracy.samples_per_level = 0;
  accuracy.first_level = 2;
  accuracy.directions.half_vectors = hemisphere(400);
  accuracy.footprints_per_octave = 0;  // half vectors without lights do not give n . l
  std::map<std::string, double> sums;
  std::map<std::string, int> counts;
  for (const AccuracyRow& row : measure_accuracy(test_device(), mipmap, map, accuracy, nullptr)) {
    sums[row.brdf.text()] += row.error;
    ++counts[row.brdf.text()];
  }
  for (auto& [brdf, sum] : sums) sum /= counts[brdf];
  return sums;
}

TEST(GmmAgainstVmfTest, IsAlikeOnTopAndWorseNearTheRim) {
  double before = 0.0;
  for (const double tilt : {0.0, 30.0, 60.0, 75.0, 85.0}) {
    const NormalMap map = tilted_map(tilt);
    std::map<std::string, double> gmm = errors_of(map, Representation::kGmm),
                                  vmf = errors_of(map, Representation::kMovmf);
    for (const auto& [brdf, error] : gmm)
      RecordProperty(fmt::format("{}_{}", brdf, tilt),
                     fmt::format("gmm {:.1f} vmf {:.1f}", 100 * error, 100 * vmf[brdf]));
    const double s100 = gmm["blinn-phong:100"], excess = s100 / vmf["blinn-phong:100"];
    if (tilt == 0.0) {
      EXPECT_LT(excess, 1.3);
      EXPECT_LT(s100, 0.1);
    }
    EXPECT_GT(s100, before) << tilt << ": worse with every step";
    before = s100;
    if (tilt >= 60.0) {
      EXPECT_GT(excess, 2.0) << tilt;
    }
    EXPECT_LT(gmm["lambert"], 0.2) << tilt;
  }
}

// For any prior, the first and second moments of the coordinates equal the moments of the texels.
TEST(GmmMomentsTest, FirstAndSecondMomentsAreThoseOfTheNormals) {
  const NormalMap map = tilted_map(50.0);
  FitReport report;
  MovmfSettings settings;
  settings.representation = Representation::kGmm;
  settings.search_start = false;
  const MovmfMipmap mipmap = bake_movmf(test_device(), map, nullptr, settings, report, nullptr);
  glm::dvec3 exact(0.0);
  for (std::size_t i = 0; i < map.x.size(); ++i) {
    const double x = static_cast<double>(map.x[i]), y = static_cast<double>(map.y[i]);
    exact += glm::dvec3(x, y, x * x + y * y) / static_cast<double>(map.x.size());
  }
  for (const MovmfLevel& level : mipmap.levels) {
    glm::dvec4 sum(0.0);
    for (const auto& lobes : level.lobes)
      for (const glm::vec4& lobe : lobes) {
        sum += glm::dvec4(lobe) / static_cast<double>(lobes.size());
        EXPECT_GE(gmm_variance(lobe), 0.0f);
      }
    EXPECT_NEAR(sum.w, 1.0, 1e-6) << level.width;
    EXPECT_LT(glm::length(glm::dvec3(sum) - exact), 3e-6) << level.width;
  }
}

}  // namespace
}  // namespace multum
