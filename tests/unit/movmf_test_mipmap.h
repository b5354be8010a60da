// SPDX-License-Identifier: Apache-2.0
// Mipmaps of random lobes, as a bake would leave them before rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "host/asset/movmf_mipmap.h"

namespace multum::testing {

inline double uniform(std::mt19937& random) { return std::uniform_real_distribution<double>()(random); }

/// A direction at most `tilt_max` radians from +Z, even over that cap.
inline glm::dvec3 random_direction(std::mt19937& random, double tilt_max) {
  const double z = 1.0 - uniform(random) * (1.0 - std::cos(tilt_max));
  const double azimuth = uniform(random) * 2.0 * std::numbers::pi, side = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {side * std::cos(azimuth), side * std::sin(azimuth), z};
}

/// Shares that sum to 1, often very uneven, sometimes zero.
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

/// a * (r, 1) in float, as the bake stores it before rounding.
inline glm::vec4 stored_lobe(double amplitude, const glm::dvec3& r) {
  const auto a = static_cast<float>(amplitude);
  return {a * glm::vec3(r), a};
}

/// Random lobes of every sharpness, a fifth of them single directions.
inline MovmfMipmap random_mipmap(int width, int height, int lobe_count, bool colours, StorageEncoding encoding,
                                 unsigned seed) {
  std::mt19937 random(seed);
  MovmfMipmap mipmap;
  mipmap.encoding = encoding;
  mipmap.wrap_s = WrapMode::kClamp;
  mipmap.wrap_t = WrapMode::kMirror;
  mipmap.provenance = {"multum test", "map.png", std::string(64, 'a'), "{\"lobes\":4}", std::string(64, 'b'), "[]", ""};
  const auto count = static_cast<std::size_t>(lobe_count);
  for (int l = 0; l < mip_level_count(width, height); ++l) {
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

}  // namespace multum::testing
