// SPDX-License-Identifier: Apache-2.0
// Computes averages of a plane that arrives row by row, and the reference from these averages. Compares both with plain
// averages in double precision.
#include "host/bakes/accuracy/accuracy_reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "host/formats/brdf/brdf_text.h"
#include "host/formats/brdf/facet_distribution.h"
#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

double uniform_above_zero(std::mt19937& random) { return (static_cast<double>(random() >> 8) + 0.5) * 0x1p-24; }

std::vector<PlaneSize> levels_of(PlaneSize map) {
  std::vector<PlaneSize> levels;
  for (int l = 0; (std::max(map.width, map.height) >> l) > 0; ++l)
    levels.push_back({std::max(1, map.width >> l), std::max(1, map.height >> l)});
  return levels;
}

std::vector<std::vector<int>> some_texels(const std::vector<PlaneSize>& levels, double share, std::mt19937& random) {
  std::vector<std::vector<int>> texels(levels.size());
  for (std::size_t l = 0; l < levels.size(); ++l)
    for (int i = 0; i < levels[l].width * levels[l].height; ++i)
      if (uniform_above_zero(random) < share) texels[l].push_back(i);
  return texels;
}

constexpr PlaneSize kSizes[] = {{1, 1}, {64, 32}, {37, 20}, {23, 61}, {300, 7}, {1, 19}, {255, 130}};

// Calls body(level, slot, average) for each selected texel. `average` is the mean of `finest` over the covered area.
template <typename Body>
void for_each_average(const std::vector<double>& finest, const std::vector<PlaneSize>& levels,
                      const TexelSelection& texels, const Body& body) {
  for (int l = 0; l < static_cast<int>(levels.size()); ++l) {
    const PlaneSize size = levels[static_cast<std::size_t>(l)];
    const std::vector<double> averages = average_over_texels(finest, levels[0], size, 1);
    for (int r = 0; r < size.height; ++r)
      for (std::size_t slot = texels.row_begin(l, r); slot < texels.row_end(l, r); ++slot)
        body(l, slot, averages[static_cast<std::size_t>(r * size.width + texels.column(slot))]);
  }
}

TEST(TexelAveragesTest, EqualThoseOfWholePlanes) {
  std::mt19937 random(1);
  for (const PlaneSize map : kSizes)
    for (const double share : {1.0, 0.1}) {
      const std::vector<PlaneSize> levels = levels_of(map);
      const TexelSelection texels(levels, some_texels(levels, share, random));
      std::vector<double> plane(static_cast<std::size_t>(map.width * map.height));
      // Values over many orders of magnitude.
      for (double& value : plane) value = std::pow(uniform_above_zero(random), 9.0);
      const TexelAverages averages(texels, static_cast<int>(levels.size()));
      ASSERT_EQ(averages.slot_count(), texels.slot_count());
      std::vector<double> sums(averages.slot_count(), 0.0), row(averages.row_length());
      for (int y = 0; y < map.height; ++y) {
        std::copy_n(plane.begin() + y * map.width, map.width, row.begin());
        averages.add_row(y, row.data(), sums.data(), 1);
      }
      for_each_average(plane, levels, texels, [&](int level, std::size_t slot, double value) {
        ASSERT_NEAR(sums[slot] * averages.share(level), value, 1e-13 * value) << map.width << " x " << map.height;
      });
    }
}

struct Planes {
  explicit Planes(PlaneSize size) {
    std::mt19937 random(2);
    const auto count = static_cast<std::size_t>(size.width * size.height);
    for (std::vector<float>& plane : normals) plane.resize(count);
    for (std::vector<float>& plane : albedo) plane.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const glm::vec3 n(
          glm::normalize(glm::dvec3(uniform_above_zero(random) - 0.5, uniform_above_zero(random) - 0.5, 0.5)));
      for (std::size_t p = 0; p < 3; ++p) {
        normals[p][i] = n[static_cast<int>(p)];
        albedo[p][i] = static_cast<float>(uniform_above_zero(random));
      }
    }
  }
  std::array<const float*, 3> normal_rows() const { return {normals[0].data(), normals[1].data(), normals[2].data()}; }
  std::array<const float*, 3> albedo_rows() const { return {albedo[0].data(), albedo[1].data(), albedo[2].data()}; }
  std::array<std::vector<float>, 3> normals, albedo;
};

const glm::dvec3 kOmega = glm::normalize(glm::dvec3(0.3, -0.2, 0.8));
const std::vector<double> kExponents = {500.0, 1.0, 20.0, 2.5};

TEST(AccuracyReferenceTest, IsTheAverageOverAllNormals) {
  for (const PlaneSize map : kSizes) {
    const Planes planes(map);
    const std::vector<PlaneSize> levels = levels_of(map);
    std::mt19937 random(3);
    const TexelSelection texels(levels, some_texels(levels, 0.5, random));
    const TexelAverages averages(texels, static_cast<int>(levels.size()));
    const PlaneStore normals(map.width, map.height, planes.normal_rows());
    const PlaneStore albedo(map.width, map.height, planes.albedo_rows());
    BrdfReference reference(averages, power_values(kOmega, kExponents), true);
    PlaneAverages means(averages, true);
    stream_rows({normals, &albedo}, {2}, {&reference, &means}, nullptr);
    const auto expect_averages = [&](const TexelSums& found, std::size_t value, const auto& finest_value) {
      std::vector<double> finest;
      for (std::size_t i = 0; i < planes.normals[0].size(); ++i) finest.push_back(finest_value(i));
      for_each_average(finest, levels, texels, [&](int level, std::size_t slot, double one) {
        ASSERT_NEAR(found.at(slot, value), one, 1e-12 * std::abs(one) + 1e-15) << value << " level " << level;
      });
    };
    for (std::size_t p = 0; p < 3; ++p) {
      expect_averages(means, p, [&](std::size_t i) { return static_cast<double>(planes.normals[p][i]); });
      expect_averages(means, 3 + p, [&](std::size_t i) { return static_cast<double>(planes.albedo[p][i]); });
    }
    for (std::size_t e = 0; e < kExponents.size(); ++e)
      for (std::size_t channel = 0; channel < 4; ++channel)
        expect_averages(reference, channel * kExponents.size() + e, [&](std::size_t i) {
          const glm::dvec3 n(planes.normals[0][i], planes.normals[1][i], planes.normals[2][i]);
          const double f = std::pow(std::max(0.0, glm::dot(kOmega, n)), kExponents[e]);
          return channel == 0 ? f : f * static_cast<double>(planes.albedo[channel - 1][i]);
        });
  }
}

// Tests that, for several BRDF families in any order, the average multiplied by highlight_scale() equals the density.
TEST(AccuracyReferenceTest, TakesEveryHighlight) {
  const PlaneSize map{37, 61};
  const Planes planes(map);
  const std::vector<PlaneSize> levels = levels_of(map);
  std::mt19937 random(5);
  const TexelSelection texels(levels, some_texels(levels, 0.5, random));
  const TexelAverages averages(texels, static_cast<int>(levels.size()));
  const PlaneStore normals(map.width, map.height, planes.normal_rows());
  std::vector<Highlight> highlights;
  for (const char* text :
       {"ggx:0.4", "blinn-phong:33.5", "torrance-sparrow:0.2", "blinn-phong:20", "charlie:0.5", "ggx:0.9"})
    highlights.push_back(make_highlight(AccuracyBrdf::named(text), parse_brdf("brdf", text, 4)));
  BrdfReference reference(averages, highlight_values(kOmega, highlights), false);
  stream_rows({normals, nullptr}, {2}, {&reference}, nullptr);
  for (std::size_t f = 0; f < highlights.size(); ++f) {
    std::vector<double> finest;
    for (std::size_t i = 0; i < planes.normals[0].size(); ++i) {
      const glm::dvec3 n(planes.normals[0][i], planes.normals[1][i], planes.normals[2][i]);
      finest.push_back(facet_density(highlights[f].brdf, 1.0 - glm::dot(kOmega, n)).y);
    }
    for_each_average(finest, levels, texels, [&](int level, std::size_t slot, double one) {
      ASSERT_NEAR(highlight_scale(highlights[f]) * reference.at(slot, f), one, 1e-5 * one + 1e-9)
          << highlights[f].id.text() << " level " << level;
    });
  }
}

// The results are equal bit for bit.
TEST(AccuracyReferenceTest, DoesNotDependOnThreadsBandsOrWhereThePlanesAre) {
  const testing::TemporaryFolder folder;
  for (const PlaneSize map : {PlaneSize{64, 32}, PlaneSize{37, 61}}) {
    const Planes planes(map);
    const std::vector<PlaneSize> levels = levels_of(map);
    std::mt19937 random(4);
    const TexelSelection texels(levels, some_texels(levels, 0.7, random));
    const TexelAverages averages(texels, static_cast<int>(levels.size()));
    const PlaneStore in_memory(map.width, map.height, planes.normal_rows());
    PlaneStore in_file(map.width, map.height, folder.path());
    in_file.write_rows(0, map.height, planes.normal_rows());
    std::vector<std::vector<double>> found;
    for (const PlaneStore* normals : {&in_memory, static_cast<const PlaneStore*>(&in_file)})
      for (const StreamSettings& settings :
           {StreamSettings{1, 0}, StreamSettings{2, 1}, StreamSettings{3, 7}, StreamSettings{5, 1000}}) {
        BrdfReference first(averages, power_values(kOmega, kExponents), false),
            second(averages, power_values(-kOmega, {20.0}), false);
        stream_rows({*normals, nullptr}, settings, {&first, &second}, nullptr);
        std::vector<double> values;
        for (std::size_t slot = 0; slot < texels.slot_count(); ++slot) {
          for (std::size_t e = 0; e < kExponents.size(); ++e) values.push_back(first.at(slot, e));
          values.push_back(second.at(slot, 0));
        }
        found.push_back(std::move(values));
      }
    for (const std::vector<double>& values : found) EXPECT_EQ(values, found.front());
  }
}

TEST(AccuracyReferenceTest, Cancels) {
  const PlaneSize map = {8, 8};
  const Planes planes(map);
  const TexelSelection texels({map}, {{3}});
  const TexelAverages averages(texels, 1);
  BrdfReference reference(averages, power_values(kOmega, kExponents), false);
  const PlaneStore normals(map.width, map.height, planes.normal_rows());
  int calls = 0;
  Progress progress([&](const ProgressEvent&) { return ++calls < 3; });
  EXPECT_THROW(stream_rows({normals, nullptr}, {1, 1}, {&reference}, &progress), Cancelled);
  EXPECT_EQ(calls, 3);
}

}  // namespace
}  // namespace multum
