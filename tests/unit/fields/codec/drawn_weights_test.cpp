// SPDX-License-Identifier: Apache-2.0
// Tests the weights of errors with filter matrices whose effect is known.
#include <gtest/gtest.h>

#include "host/fields/codec/decoder/wavelet_transform.h"
#include "host/fields/codec/drawn_weights.h"
#include "tests/unit/fields/codec/codec_test_data.h"

namespace multum {
namespace {

/// Makes a matrix that reads only the left half of the texture.
FilterMatrix half_seen(int width, int height, int block) { return seen_columns(width, height, block, 0, width / 2); }

std::vector<float> energies_of(const FilterMatrix& matrix, const CoefficientLayout& layout) {
  return coefficient_energies({matrix}, layout).at(0);
}

TEST(DrawnWeights, OneTexelAPixelWeighsEveryCosineOne) {
  const FilterMatrix matrix = half_seen(64, 32, 1);
  const CoefficientLayout layout{ImageCoder::kDct, 64, 32, 8};
  const auto energies = energies_of(matrix, layout);
  ASSERT_EQ(energies.size(), 64u * 32u);
  for (std::size_t i = 0; i < energies.size(); ++i) EXPECT_NEAR(energies[i], i / 64 % 8 < 4 ? 1.0f : 0.0f, 1e-4f) << i;
}

TEST(DrawnWeights, PixelsOverManyTexelsWeighHighFrequenciesLess) {
  const FilterMatrix matrix = half_seen(64, 32, 4);
  const auto energies = energies_of(matrix, {ImageCoder::kDct, 64, 32, 8});
  // The constant basis image of a block is 1/8 in its 64 texels, and hence 1/8 in its 4 pixels, so its energy is 4/64.
  // Frequency 4 along a row sums to zero over every 4 texels.
  EXPECT_NEAR(energies[0], 4.0f / 64.0f, 1e-4f);
  EXPECT_LT(energies[7], 0.2f * energies[0]);
  EXPECT_NEAR(energies[4 * 64], 0.0f, 1e-6f);  // no pixel sees the fifth block
}

TEST(DrawnWeights, WaveletsAreHeaviestWhereTheyAreSeen) {
  const FilterMatrix matrix = half_seen(64, 32, 1);
  const auto energies = energies_of(matrix, {ImageCoder::kWavelet, 64, 32, 16});
  for (const WaveletBand& band : wavelet_bands(64, 32)) {
    const std::size_t row = (band.y + band.height / 2) * 64 + band.x;
    float sum = 0.0f;  // the sum over the seen half except for its border
    std::size_t count = 0;
    for (std::size_t y = 0; y < band.height; ++y)
      for (std::size_t x = 0; x + 1 < band.width / 2; ++x, ++count) sum += energies[(band.y + y) * 64 + band.x + x];
    EXPECT_NEAR(sum / static_cast<float>(count), 1.0f, 0.35f) << band.depth << ' ' << band.kind;
    if (band.width >= 8) {
      EXPECT_LT(energies[row + band.width - 1], 0.05f) << band.depth << ' ' << band.kind;
    }
  }
}

TEST(DrawnWeights, PosesTogetherWeighWhatEachWeighsAlone) {
  const FilterMatrix sharp = half_seen(64, 32, 1), coarse = half_seen(64, 32, 4);
  for (const CoefficientLayout& layout :
       {CoefficientLayout{ImageCoder::kDct, 64, 32, 8}, CoefficientLayout{ImageCoder::kWavelet, 64, 32, 16}}) {
    const auto together = coefficient_energies({sharp, coarse}, layout);
    ASSERT_EQ(together.size(), 2u);
    EXPECT_EQ(together[0], energies_of(sharp, layout));
    EXPECT_EQ(together[1], energies_of(coarse, layout));
  }
}

TEST(DrawnWeights, MassesSumToThePixels) {
  const auto masses = texel_masses(half_seen(64, 32, 2));
  double sum = 0.0;
  for (const float mass : masses) sum += static_cast<double>(mass);
  EXPECT_NEAR(sum, 16.0 * 16.0, 1e-3);
  EXPECT_EQ(masses[40], 0.0f);
}

TEST(DrawnWeights, DimLayersShowLess) {
  const FilterMatrix matrix = half_seen(64, 32, 1);
  const std::size_t texels = 3 * static_cast<std::size_t>(matrix.layout().texel_count);
  const std::vector<float> bright(texels, 0.3f), dim(texels, 0.1f), black(texels, 0.0f);
  const auto alone = layer_shares(matrix, {&bright});
  EXPECT_NEAR(alone[0][0], 1.0f, 1e-5f);
  const auto both = layer_shares(matrix, {&bright, &dim});
  EXPECT_NEAR(both[0][0], std::pow(0.75, 2.0 - 2.0 / 2.2), 1e-4);
  EXPECT_NEAR(both[1][0], std::pow(0.25, 2.0 - 2.0 / 2.2), 1e-4);
  EXPECT_NEAR(both[1][7], both[1][0], 1e-4f);  // unseen blocks get the mean of the other blocks
  EXPECT_LT(layer_shares(matrix, {&bright, &black})[1][0], 1e-4f);
}

TEST(DrawnWeights, CellsFollowThePlaceOfCoefficients) {
  const auto cells = cells_of_coefficients({ImageCoder::kDct, 64, 32, 8});
  EXPECT_EQ(cells[0], 0u);
  EXPECT_EQ(cells[2 * 64], 1u);            // the third block is at x = 16
  EXPECT_EQ(cells[(2 * 8 + 7) * 64], 7u);  // row 2 of blocks is at y = 16, which is in cells 4 to 7
  const auto wavelets = cells_of_coefficients({ImageCoder::kWavelet, 64, 32, 16});
  const WaveletBand finest = wavelet_bands(64, 32).back();
  EXPECT_EQ(wavelets[finest.y * 64 + finest.x], 0u);
  EXPECT_EQ(wavelets[(finest.y + finest.height - 1) * 64 + finest.x + finest.width - 1], 7u);
}

}  // namespace
}  // namespace multum
