// SPDX-License-Identifier: Apache-2.0
// Tests kernels/block_encoding.cl by the errors of its blocks, which are decoded on the host. Compares these errors
// with the lowest possible error (BC4), with a search from many starting points (BC7), and with libsquish.
#include <gtest/gtest.h>

#include <squish.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "host/delivery/export/block_decoding.h"
#include "host/delivery/export/block_encoder.h"
#include "host/lab/reference/block_encoding.h"
#include "tests/fixtures/random_values.h"
#include "tests/fixtures/test_device.h"

namespace multum {
namespace {

using reference::BlockColours;
using reference::BlockValues;
using testing::test_device;
using testing::uniform24;

constexpr std::size_t kBlocks = 24;  // the number of blocks of each kind

// Describes one channel of a kind of blocks, which is a position on a slope with waves, plus noise.
struct Relief {
  double middle, range, noise;  // 0 to 255
};

BlockValues relief_values(const Relief& relief, std::mt19937& random) {
  const double angle = 6.3 * uniform24(random), waves = 0.3 + 1.2 * uniform24(random), phase = 6.3 * uniform24(random);
  const double middle = relief.middle + 40.0 * (uniform24(random) - 0.5);
  BlockValues values{};
  for (std::size_t i = 0; i < 16; ++i) {
    const double along = std::cos(angle) * static_cast<double>(i % 4) + std::sin(angle) * static_cast<double>(i / 4);
    values[i] = std::clamp(
        middle + relief.range * 0.5 * std::sin(waves * along + phase) + relief.noise * (uniform24(random) - 0.5), 0.0,
        255.0);
  }
  return values;
}

BlockValues constant_values(double value) {
  BlockValues values{};
  values.fill(value);
  return values;
}

// Places the blocks in one row of blocks, which is 4 texels high.
std::vector<glm::vec4> texels_of(const std::vector<BlockColours>& blocks) {
  std::vector<glm::vec4> texels(16 * blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (std::size_t i = 0; i < 16; ++i)
      for (int c = 0; c < 3; ++c)
        texels[(i / 4) * 4 * blocks.size() + 4 * b + i % 4][c] =
            static_cast<float>(blocks[b][static_cast<std::size_t>(c)][i] / 255.0);
  return texels;
}

// Returns sums of squared differences over the channels of the format.
std::vector<double> errors_of(TexelFormat format, const std::vector<BlockColours>& blocks) {
  BlockEncoder encoder(test_device());
  const std::vector<std::uint8_t> bytes =
      encoder.encode(format, static_cast<int>(4 * blocks.size()), 4, texels_of(blocks));
  const auto block_bytes = static_cast<std::size_t>(info_of(format).block_bytes);
  EXPECT_EQ(bytes.size(), block_bytes * blocks.size());
  std::vector<double> errors;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const BlockTexels decoded = decode_block(format, bytes.data() + b * block_bytes);
    double sum = 0.0;
    for (std::size_t i = 0; i < 16; ++i)
      for (int c = 0; c < std::min(3, info_of(format).channels); ++c) {
        const double d = blocks[b][static_cast<std::size_t>(c)][i] - 255.0 * static_cast<double>(decoded[i][c]);
        sum += d * d;
      }
    for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(decoded[i].w, 1.0f);
    errors.push_back(sum);
  }
  return errors;
}

double sum_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum;
}

struct ScalarKind {
  std::string name;
  std::function<BlockValues(std::mt19937&)> make;
};

const std::vector<ScalarKind>& scalar_kinds() {
  static const std::vector<ScalarKind> kinds = {{"slopes",
                                                 [](std::mt19937& r) {
                                                   return relief_values({128.0, 60.0, 4.0}, r);
                                                 }},
                                                {"nearly flat",
                                                 [](std::mt19937& r) {
                                                   return relief_values({128.0, 3.0, 1.0}, r);
                                                 }},
                                                {"steep and rough",
                                                 [](std::mt19937& r) {
                                                   return relief_values({128.0, 250.0, 60.0}, r);
                                                 }},
                                                {"noise alone",
                                                 [](std::mt19937& r) {
                                                   return relief_values({128.0, 0.0, 200.0}, r);
                                                 }},
                                                {"at the limits",
                                                 [](std::mt19937& r) {
                                                   return relief_values({250.0, 80.0, 10.0}, r);
                                                 }},
                                                {"one that stands out", [](std::mt19937& r) {
                                                   BlockValues values = relief_values({100.0, 10.0, 2.0}, r);
                                                   values[r() % 16] = 230.0;
                                                   return values;
                                                 }}};
  return kinds;
}

double squish_error(const BlockValues& values) {
  squish::u8 texels[64] = {}, block[8];
  for (std::size_t i = 0; i < 16; ++i) texels[4 * i] = static_cast<squish::u8>(std::lround(values[i]));
  squish::Compress(texels, block, squish::kBc4);
  const BlockTexels decoded = decode_block(TexelFormat::kBc4, block);
  double sum = 0.0;
  for (std::size_t i = 0; i < 16; ++i) {
    const double d = values[i] - 255.0 * static_cast<double>(decoded[i].x);
    sum += d * d;
  }
  return sum;
}

// For each kind, the error is within 1 % of the lowest possible error. The error of every block is at most 1.5 times
// the lowest error, or exceeds it by at most twice the rounding error of 8 bits. The errors are lower than the errors
// of libsquish, which reads only 8-bit values.
TEST(BlockEncoding, Bc4IsNearTheLeast) {
  std::mt19937 random(31);
  for (const ScalarKind& kind : scalar_kinds()) {
    std::vector<BlockColours> blocks;
    for (std::size_t b = 0; b < kBlocks; ++b) blocks.push_back({kind.make(random), {}, {}});
    const std::vector<double> errors = errors_of(TexelFormat::kBc4, blocks);
    double least = 0.0, of_squish = 0.0;
    for (std::size_t b = 0; b < kBlocks; ++b) {
      const double best = reference::least_scalar_error(blocks[b][0]);
      least += best;
      of_squish += squish_error(blocks[b][0]);
      EXPECT_GE(errors[b], best - 1e-2) << kind.name << ", block " << b;
      EXPECT_LE(errors[b], std::max(1.5 * best, best + 2.0 * 16.0 / 12.0)) << kind.name << ", block " << b;
    }
    std::printf("%s: error relative to the lowest: ours %.4f, libsquish %.4f\n", kind.name.c_str(),
                sum_of(errors) / least, of_squish / least);
    EXPECT_LE(sum_of(errors), 1.01 * least) << kind.name;
    EXPECT_LE(sum_of(errors), of_squish) << kind.name;
  }
}

TEST(BlockEncoding, Bc4HasConstantsAndLimits) {
  std::vector<BlockColours> blocks;
  for (const double value : {0.0, 1.0, 127.0, 200.0, 254.0, 255.0}) blocks.push_back({constant_values(value), {}, {}});
  BlockValues two{}, limits{};
  for (std::size_t i = 0; i < 16; ++i) {
    two[i] = i % 3 == 0 ? 17.0 : 211.0;
    limits[i] = i % 3 == 0 ? 0.0 : i % 3 == 1 ? 255.0 : 90.0;
  }
  blocks.push_back({two, {}, {}});
  blocks.push_back({limits, {}, {}});
  for (const double error : errors_of(TexelFormat::kBc4, blocks)) EXPECT_LT(error, 1e-3);
}

TEST(BlockEncoding, Bc5IsTwoOfBc4) {
  std::mt19937 random(32);
  std::vector<BlockColours> both, red, green;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    both.push_back({relief_values({128.0, 60.0, 4.0}, random), relief_values({90.0, 30.0, 9.0}, random), {}});
    red.push_back({both[b][0], {}, {}});
    green.push_back({both[b][1], {}, {}});
  }
  const std::vector<double> sums = errors_of(TexelFormat::kBc5, both), reds = errors_of(TexelFormat::kBc4, red),
                            greens = errors_of(TexelFormat::kBc4, green);
  for (std::size_t b = 0; b < kBlocks; ++b) EXPECT_NEAR(sums[b], reds[b] + greens[b], 1e-3);
}

struct ColourKind {
  std::string name;
  double ratio_most;  // the largest allowed error of this kind, as a multiple of the error of the search
  std::function<BlockColours(std::mt19937&)> make;
};

const std::vector<ColourKind>& colour_kinds() {
  const auto edge = [](std::mt19937& r) {
    BlockValues mask{};
    const double angle = 6.3 * uniform24(r);
    for (std::size_t i = 0; i < 16; ++i)
      mask[i] =
          std::cos(angle) * (static_cast<double>(i % 4) - 1.5) + std::sin(angle) * (static_cast<double>(i / 4) - 1.5) >
                  0.0
              ? 255.0
              : 0.0;
    return mask;
  };
  static const std::vector<ColourKind> kinds = {
      {"roughness alone", 1.15,
       [](std::mt19937& r) {
         return BlockColours{constant_values(255.0), relief_values({120.0, 40.0, 6.0}, r), constant_values(255.0)};
       }},
      {"dielectric with occlusion", 1.15,
       [](std::mt19937& r) {
         const BlockValues base = relief_values({120.0, 40.0, 6.0}, r);
         BlockValues occlusion = base;
         for (double& value : occlusion) value = std::min(255.0, 180.0 + 0.5 * value + 6.0 * uniform24(r));
         return BlockColours{occlusion, base, constant_values(0.0)};
       }},
      {"metal's edge", 1.05,
       [=](std::mt19937& r) {
         const BlockValues mask = edge(r);
         BlockValues roughness = relief_values({100.0, 20.0, 4.0}, r);
         for (std::size_t i = 0; i < 16; ++i) roughness[i] = std::min(255.0, roughness[i] + 0.3 * mask[i]);
         return BlockColours{relief_values({220.0, 10.0, 3.0}, r), roughness, mask};
       }},
      {"channels of their own", 1.05,
       [](std::mt19937& r) {
         return BlockColours{relief_values({200.0, 40.0, 6.0}, r), relief_values({120.0, 60.0, 6.0}, r),
                             relief_values({90.0, 50.0, 6.0}, r)};
       }},
      {"noise", 1.02, [](std::mt19937& r) {
         return BlockColours{relief_values({128.0, 0.0, 200.0}, r), relief_values({128.0, 0.0, 200.0}, r),
                             relief_values({128.0, 0.0, 200.0}, r)};
       }}};
  return kinds;
}

TEST(BlockEncoding, Bc7IsNearWhatASearchFinds) {
  std::mt19937 random(33);
  constexpr std::size_t kSearched = 6;  // the search takes half a second for each block
  for (const ColourKind& kind : colour_kinds()) {
    std::vector<BlockColours> blocks;
    for (std::size_t b = 0; b < kSearched; ++b) blocks.push_back(kind.make(random));
    const std::vector<double> errors = errors_of(TexelFormat::kBc7, blocks);
    double searched = 0.0;
    for (const BlockColours& block : blocks) searched += reference::colour_error_by_search(block);
    std::printf("%s: error %.2f per block, %.3f times that of the search\n", kind.name.c_str(),
                sum_of(errors) / static_cast<double>(kSearched), sum_of(errors) / searched);
    EXPECT_LE(sum_of(errors), kind.ratio_most * searched) << kind.name;
  }
}

// Repeats the search with the third channel in alpha. The error equals the error of colour blocks if both searches
// choose mode 4, 5 or 6 and blue is 1.
TEST(BlockEncoding, Bc7HasTheThirdChannelAsAlpha) {
  std::mt19937 random(34);
  BlockEncoder encoder(test_device());
  for (const ColourKind& kind : colour_kinds()) {
    std::vector<BlockColours> blocks;
    for (int b = 0; b < 64; ++b) blocks.push_back(kind.make(random));
    std::vector<glm::vec4> texels = texels_of(blocks);
    for (glm::vec4& texel : texels) texel = {texel.x, texel.y, 0.5f, texel.z};
    const int width = static_cast<int>(4 * blocks.size());
    const std::vector<std::uint8_t> bytes = encoder.encode(TexelFormat::kBc7, width, 4, texels, BlockColour::kRga);
    const std::vector<double> as_colours = errors_of(TexelFormat::kBc7, blocks);
    double sum = 0.0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const BlockTexels decoded = decode_block(TexelFormat::kBc7, bytes.data() + 16 * b);
      double error = 0.0;
      for (std::size_t i = 0; i < 16; ++i) {
        EXPECT_NEAR(decoded[i].z, 1.0f, 1.01f / 255.0f);
        const float found[3] = {decoded[i].x, decoded[i].y, decoded[i].w};
        for (std::size_t c = 0; c < 3; ++c)
          error += std::pow(blocks[b][c][i] - 255.0 * static_cast<double>(found[c]), 2.0);
      }
      const bool has_two_lines = (bytes[16 * b] & 3) == 2;
      EXPECT_FALSE(has_two_lines) << "mode 1 has no alpha";
      sum += error;
    }
    // Mode 1 has two lines of colours. Without it, the error at the edge of a metal area is 4.4 times as high.
    EXPECT_LT(sum, 6.0 * sum_of(as_colours) + 1.0) << kind.name;
  }
}

// If the sides are not multiples of 4, the last texel is repeated to fill the last blocks.
TEST(BlockEncoding, FillsUpBlocks) {
  BlockEncoder encoder(test_device());
  std::vector<glm::vec4> texels(15, glm::vec4(0.25f));
  std::vector<glm::vec4> whole(32, glm::vec4(0.25f));
  texels[14] = glm::vec4(0.75f);
  // In a texture of 5 x 3 texels, the last texel fills the lower right of the second block.
  const std::vector<std::uint8_t> filled = encoder.encode(TexelFormat::kBc4, 5, 3, texels);
  for (std::size_t row = 2; row < 4; ++row)
    for (std::size_t column = 4; column < 8; ++column) whole[8 * row + column] = glm::vec4(0.75f);
  EXPECT_EQ(filled, encoder.encode(TexelFormat::kBc4, 8, 4, whole));
}

}  // namespace
}  // namespace multum
