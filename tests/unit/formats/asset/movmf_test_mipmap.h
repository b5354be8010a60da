// SPDX-License-Identifier: Apache-2.0
// Makes mipmaps of random lobes, like the result of a bake before rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum::testing {

constexpr double kDegree = std::numbers::pi / 180.0;

inline double uniform(std::mt19937& random) { return std::uniform_real_distribution<double>()(random); }

/// Returns a direction at most `tilt_max` radians from +Z, evenly distributed over that cap.
inline glm::dvec3 random_direction(std::mt19937& random, double tilt_max) {
  const double z = 1.0 - uniform(random) * (1.0 - std::cos(tilt_max));
  const double azimuth = uniform(random) * 2.0 * std::numbers::pi, side = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {side * std::cos(azimuth), side * std::sin(azimuth), z};
}

/// Returns shares that sum to 1. The shares are often very unequal and sometimes zero.
inline std::vector<double> random_shares(std::mt19937& random, int count) {
  std::vector<double> shares(static_cast<std::size_t>(count));
  const double unevenness = 8.0 * uniform(random);
  double sum = 0.0;
  for (double& share : shares) {
    share = uniform(random) < 0.1 ? 0.0 : std::exp(-unevenness * uniform(random) * 2.0);
    sum += share;
  }
  if (sum == 0.0) shares[0] = sum = 1.0;
  for (double& share : shares) share /= sum;
  return shares;
}

/// Returns a * (r, 1) in float, as the bake stores it before rounding.
inline glm::vec4 stored_lobe(double amplitude, const glm::dvec3& r) {
  const auto a = static_cast<float>(amplitude);
  return {a * glm::vec3(r), a};
}

/// Makes level 0 as a bake does: each texel has a single direction, which belongs completely to one lobe.
inline MovmfFinest random_finest(std::mt19937& random, int width, int height, int lobe_count, bool colours) {
  MovmfFinest rows{width, height, {}, {}, {}};
  for (int i = 0; i < width * height; ++i) {
    rows.normals.emplace_back(random_direction(random, std::numbers::pi / 2.0));
    rows.lobe.push_back(static_cast<std::uint8_t>(random() % static_cast<unsigned>(lobe_count)));
    if (colours) rows.colours.emplace_back(uniform(random), uniform(random), uniform(random));
  }
  return rows;
}

/// Makes random lobes of every sharpness. A fifth of them are single directions, and level 0 is random_finest().
inline MovmfMipmap random_mipmap(int width, int height, int lobe_count, bool colours, StorageEncoding encoding,
                                 unsigned seed) {
  std::mt19937 random(seed);
  MovmfMipmap mipmap;
  mipmap.header.encoding = encoding;
  mipmap.header.wrap_s = WrapMode::kClamp;
  mipmap.header.wrap_t = WrapMode::kMirror;
  mipmap.header.provenance = {"multum test", "map.png", std::string(64, 'a'), "{\"lobes\":4}", std::string(64, 'b'),
                              "[]",          ""};
  const auto count = static_cast<std::size_t>(lobe_count);
  for (int l = 0; l < mip_level_count(width, height); ++l) {
    if (l == 0) {
      mipmap.levels.push_back(expand(random_finest(random, width, height, lobe_count, colours), lobe_count));
      continue;
    }
    MovmfLevel level;
    level.width = mip_level_size(width, l);
    level.height = mip_level_size(height, l);
    const auto texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
    level.lobes.assign(count, std::vector<glm::vec4>(texels));
    if (colours) level.colours.assign(count, std::vector<glm::vec3>(texels));
    for (std::size_t i = 0; i < texels; ++i) {
      const std::vector<double> shares = random_shares(random, lobe_count);
      for (std::size_t j = 0; j < count; ++j) {
        const double length = uniform(random) < 0.2 ? 1.0 : 1.0 - std::pow(10.0, -5.0 * uniform(random));
        level.lobes[j][i] = stored_lobe(shares[j], length * random_direction(random, std::numbers::pi / 2.0));
        if (colours)
          level.colours[j][i] = glm::vec3(glm::dvec3(uniform(random), uniform(random), uniform(random)) * shares[j]);
      }
    }
    mipmap.levels.push_back(std::move(level));
  }
  return mipmap;
}

inline void expect_same_bits(const MovmfMipmap& found, const MovmfMipmap& expected) {
  ASSERT_EQ(found.levels.size(), expected.levels.size());
  for (std::size_t l = 0; l < expected.levels.size(); ++l) {
    const MovmfLevel &a = found.levels[l], &b = expected.levels[l];
    ASSERT_EQ(a.width, b.width);
    ASSERT_EQ(a.height, b.height);
    ASSERT_EQ(a.lobes.size(), b.lobes.size());
    ASSERT_EQ(a.colours.size(), b.colours.size());
    for (std::size_t j = 0; j < b.lobes.size(); ++j) {
      ASSERT_EQ(a.lobes[j].size(), b.lobes[j].size());
      EXPECT_TRUE(b.lobes[j].empty() ||
                  std::memcmp(a.lobes[j].data(), b.lobes[j].data(), b.lobes[j].size() * sizeof(glm::vec4)) == 0)
          << "level " << l << ", lobe " << j;
    }
    for (std::size_t j = 0; j < b.colours.size(); ++j) {
      ASSERT_EQ(a.colours[j].size(), b.colours[j].size());
      EXPECT_TRUE(b.colours[j].empty() ||
                  std::memcmp(a.colours[j].data(), b.colours[j].data(), b.colours[j].size() * sizeof(glm::vec3)) == 0)
          << "level " << l << ", colour " << j;
    }
  }
}

}  // namespace multum::testing
