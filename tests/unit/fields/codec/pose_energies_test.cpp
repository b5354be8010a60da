// SPDX-License-Identifier: Apache-2.0
// Tests that poses which differ only in hidden parts do not need a measurement. The measured poses give the weights of
// the other poses.
#include <gtest/gtest.h>

#include "host/fields/codec/pose_energies.h"
#include "tests/unit/fields/codec/codec_test_data.h"

namespace multum {
namespace {

constexpr int kTexelColumns = 64, kTexelRows = 32, kPixelSide = 2;

std::vector<float> masses_between(int begin, int end) {
  return texel_masses(seen_columns(kTexelColumns, kTexelRows, kPixelSide, begin, end));
}

TEST(PosesToMeasure, EveryCellIsSeenByOneOfThem) {
  // Cells are 16 texels wide. The second pose shows most cells, and the first pose shows the rest. The other poses do
  // not show any further cells.
  std::vector<std::vector<float>> cells;
  for (const auto& [begin, end] : {std::pair(0, 16), {16, 64}, {32, 64}, {4, 12}})
    cells.push_back(cell_sums(kTexelColumns, masses_between(begin, end)));
  EXPECT_EQ(poses_to_measure(cells), (std::vector<std::size_t>{0, 1}));
}

TEST(PosesToMeasure, OfPosesThatSeeNothingOneIsMeasured) {
  EXPECT_EQ(poses_to_measure({{0.0f, 0.0f}, {0.0f, 0.0f}}), (std::vector<std::size_t>{0}));
}

TEST(PoseEnergies, HiddenCellsWeighNothingAndOthersWhatTheyWeighWhereTheyAreMeasured) {
  for (const CoefficientLayout& layout : {CoefficientLayout{ImageCoder::kDct, kTexelColumns, kTexelRows, 8},
                                          {ImageCoder::kDct, kTexelColumns, kTexelRows, 16}}) {
    const auto energies = coefficient_energies({seen_columns(kTexelColumns, kTexelRows, kPixelSide, 0, 48),
                                                seen_columns(kTexelColumns, kTexelRows, kPixelSide, 32, 64),
                                                seen_columns(kTexelColumns, kTexelRows, kPixelSide, 16, 64)},
                                               layout);
    PoseEnergies poses(3);
    poses.set_measured(0, layout, energies[0], masses_between(0, 48));
    poses.set_measured(1, layout, energies[1], masses_between(32, 64));
    poses.set_like(2, layout, {0, 1}, masses_between(16, 64));
    const auto cells = cells_of_coefficients(layout);
    EXPECT_EQ(poses.of(1, cells), energies[1]);
    const std::vector<float> like = poses.of(2, cells);
    ASSERT_EQ(like.size(), energies[2].size());
    for (std::size_t i = 0; i < like.size(); ++i) EXPECT_NEAR(like[i], energies[2][i], 1e-5f) << i;
  }
}

TEST(PoseEnergies, BlocksThatAreHiddenInPartWeighByWhatIsSeen) {
  const CoefficientLayout layout{ImageCoder::kDct, kTexelColumns, kTexelRows, 16};
  const auto energies = coefficient_energies({seen_columns(kTexelColumns, kTexelRows, kPixelSide, 0, 64),
                                              seen_columns(kTexelColumns, kTexelRows, kPixelSide, 8, 64)},
                                             layout);
  PoseEnergies poses(2);
  poses.set_measured(0, layout, energies[0], masses_between(0, 64));
  poses.set_like(1, layout, {0}, masses_between(8, 64));
  const auto cells = cells_of_coefficients(layout);
  const std::vector<float> like = poses.of(1, cells);
  double exact = 0.0, found = 0.0;  // sums over the first block
  for (std::size_t i = 0; i < 256; ++i) {
    exact += static_cast<double>(energies[1][i]);
    found += static_cast<double>(like[i]);
  }
  EXPECT_NEAR(found, exact, 0.05 * exact);
  EXPECT_GT(found, 0.5 * static_cast<double>(energies[0][0]));
}

TEST(PoseEnergies, UnmeasuredPosesTakeLittleMemory) {
  const CoefficientLayout layout{ImageCoder::kDct, kTexelColumns, kTexelRows, 8};
  const auto masses = masses_between(0, 64);
  PoseEnergies poses(2);
  poses.set_measured(0, layout, std::vector<float>(kTexelColumns * kTexelRows, 1.0f), masses);
  const std::uint64_t alone = poses.bytes();
  poses.set_like(1, layout, {0}, masses);
  EXPECT_GE(alone, kTexelColumns * kTexelRows * sizeof(float));
  EXPECT_LT(poses.bytes() - alone, alone / 20);
}

}  // namespace
}  // namespace multum
