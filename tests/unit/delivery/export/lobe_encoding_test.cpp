// SPDX-License-Identifier: Apache-2.0
// Tests the encoding of all lobes of a level together. It keeps the sum of amplitudes and the mean normal better than
// encoding each lobe separately. Each lobe keeps its direction and spread.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "host/delivery/export/lobes/lobe_encoding.h"
#include "host/formats/asset/textures/lobe_texture.h"
#include "host/foundation/base/split_mix.h"
#include "tests/fixtures/test_device.h"

namespace multum {
namespace {

constexpr int kLevelWidth = 50, kLevelHeight = 70;  // the sides are not multiples of 4, and there are more rows than in
                                                    // a band
constexpr std::size_t kLevelTexels = std::size_t{kLevelWidth} * kLevelHeight;

using Lobes = std::vector<std::vector<glm::vec4>>;

// Makes a level with four lobes that face four sides. The amplitudes, directions and spreads differ from texel to
// texel.
MovmfMipmap rough_level() {
  SplitMix64 random(54);
  MovmfMipmap mipmap;
  mipmap.levels.resize(1);
  MovmfLevel& level = mipmap.levels[0];
  level.width = kLevelWidth, level.height = kLevelHeight;
  level.lobes.assign(4, std::vector<glm::vec4>(kLevelTexels));
  for (std::size_t i = 0; i < kLevelTexels; ++i) {
    float sum = 0.0f;
    for (std::size_t j = 0; j < 4; ++j) {
      const float amplitude = static_cast<float>(0.1 + random.uniform());
      const float spread = static_cast<float>(0.1 * random.uniform() * random.uniform());
      const float x = (j % 2 == 0 ? 0.4f : -0.4f) + static_cast<float>(0.3 * random.uniform());
      const float y = (j < 2 ? 0.3f : -0.3f) + static_cast<float>(0.3 * random.uniform());
      level.lobes[j][i] = amplitude * glm::vec4(glm::normalize(glm::vec3(x, y, 1.0f)) * (1.0f - spread), 1.0f);
      sum += amplitude;
    }
    for (auto& lobe : level.lobes) lobe[i] /= sum;
  }
  return mipmap;
}

// Encodes lobes together and returns the stored values.
Lobes stored(const MovmfMipmap& mipmap, const std::vector<std::size_t>& which, LobeTexels texels) {
  Device& device = testing::test_device();
  LobeEncoder encoder(texels, device);
  LobeTexture texture{{full_header(mipmap), texels, {}}, {}};
  std::vector<LobeBasis> bases;
  Lobes lobes;
  for (const std::size_t j : which) {
    bases.push_back(fit_lobe_basis(mipmap, 0, static_cast<int>(j)));
    texture.header.lobes.push_back(encoder.unpacking(bases.back()));
    lobes.push_back(mipmap.levels[0].lobes[j]);
  }
  texture.levels = {encoder.encode(bases, kLevelWidth, kLevelHeight, lobes)};
  EXPECT_EQ(texture.levels[0].size(), which.size() * static_cast<std::size_t>(layers_per_lobe(texels)) *
                                          layer_bytes(texels, kLevelWidth, kLevelHeight));
  for (std::size_t j = 0; j < which.size(); ++j) {
    const std::vector<float> channels = lobe_channels(texture, 0, static_cast<int>(j));
    for (std::size_t i = 0; i < kLevelTexels; ++i)
      lobes[j][i] = texture.header.lobes[j].lobe(&channels[kLobeChannels * i]);
  }
  return lobes;
}

// Holds four root mean square errors: of the sum of amplitudes, of the direction of the mean normal (in radians), of
// the vector of a lobe, and of the mean vector of a lobe without its amplitude.
struct JointError {
  double sum = 0.0, angle = 0.0, lobe = 0.0, shape = 0.0;
};

JointError error_of(const Lobes& exact, const Lobes& found) {
  JointError error;
  for (std::size_t i = 0; i < kLevelTexels; ++i) {
    glm::dvec4 right(0.0), kept(0.0);
    for (std::size_t j = 0; j < exact.size(); ++j) {
      right += glm::dvec4(exact[j][i]), kept += glm::dvec4(found[j][i]);
      const glm::dvec4 difference(exact[j][i] - found[j][i]);
      error.lobe += glm::dot(difference, difference) / static_cast<double>(exact.size() * kLevelTexels);
      const auto amplitude = static_cast<double>(exact[j][i].w), stored_amplitude = static_cast<double>(found[j][i].w);
      const glm::dvec3 kept_lobe(found[j][i]), lobe(exact[j][i]);
      const glm::dvec3 shape = (kept_lobe - stored_amplitude / amplitude * lobe) / amplitude;
      error.shape += glm::dot(shape, shape) / static_cast<double>(exact.size() * kLevelTexels);
    }
    const glm::dvec3 turned = glm::normalize(glm::dvec3(right)) - glm::normalize(glm::dvec3(kept));
    error.sum += (right.w - kept.w) * (right.w - kept.w) / static_cast<double>(kLevelTexels);
    error.angle += glm::dot(turned, turned) / static_cast<double>(kLevelTexels);
  }
  return {std::sqrt(error.sum), std::sqrt(error.angle), std::sqrt(error.lobe), std::sqrt(error.shape)};
}

class LobeEncodingTest : public ::testing::TestWithParam<LobeTexels> {};

TEST_P(LobeEncodingTest, KeepsWhatLobesHaveInCommon) {
  const MovmfMipmap mipmap = rough_level();
  const Lobes& exact = mipmap.levels[0].lobes;
  Lobes one_by_one;
  for (std::size_t j = 0; j < 4; ++j) one_by_one.push_back(stored(mipmap, {j}, GetParam())[0]);
  const JointError apart = error_of(exact, one_by_one);
  const JointError together = error_of(exact, stored(mipmap, {0, 1, 2, 3}, GetParam()));
  EXPECT_LT(together.sum, 0.6 * apart.sum) << apart.sum;
  EXPECT_LT(together.angle, 0.75 * apart.angle) << apart.angle;
  EXPECT_LT(together.lobe, 1.4 * apart.lobe) << apart.lobe;
  EXPECT_LT(together.shape, 1.1 * apart.shape) << apart.shape;  // weak lobes lose no more precision than strong ones
}

INSTANTIATE_TEST_SUITE_P(Texels, LobeEncodingTest, ::testing::Values(LobeTexels::kBlocks, LobeTexels::kRgba8));

TEST(LobeEncoding, HalvesStayAsFineAsTheyAre) {
  const MovmfMipmap mipmap = rough_level();
  const JointError error = error_of(mipmap.levels[0].lobes, stored(mipmap, {0, 1, 2, 3}, LobeTexels::kRgba16f));
  EXPECT_LT(error.sum, 1e-3);
  EXPECT_LT(error.angle, 1e-3);
}

}  // namespace
}  // namespace multum
