// SPDX-License-Identifier: Apache-2.0
// Tests the pyramid over parameters: its images, the samples that use each image, the refusal of invalid lists of
// levels, and the search for the best levels.
#include <gtest/gtest.h>

#include <numeric>

#include "host/fields/codec/chunk_choice.h"

namespace multum {
namespace {

using Halvings = ParameterPyramid::Halvings;

TEST(ParameterPyramid, PlainPyramidOfEightByEight) {
  const auto pyramid = ParameterPyramid::of({8, 8}, {{3, 3}, {2, 2}, {1, 1}, {0, 0}});
  ASSERT_TRUE(pyramid);
  EXPECT_EQ(pyramid->image_count(), 85u);  // 1 + 4 + 16 + 64
  EXPECT_EQ(pyramid->image_of(0, 63), 0u);
  EXPECT_EQ(pyramid->image_of(1, 7), 2u);  // (0, 7) is in the second image of the first row
  EXPECT_EQ(pyramid->image_of(3, 9), 21u + 9u);
  EXPECT_EQ(pyramid->parent_of(0), std::nullopt);
  EXPECT_EQ(pyramid->parent_of(21 + 9), 5u + 0u);
  EXPECT_EQ(pyramid->samples_of(4),
            (std::vector<std::size_t>{36, 37, 38, 39, 44, 45, 46, 47, 52, 53, 54, 55, 60, 61, 62, 63}));
}

TEST(ParameterPyramid, EverySizeHasEverySampleOnceALevel) {
  for (const auto& sizes : std::vector<std::vector<std::size_t>>{{1}, {5}, {7, 3}, {8, 1, 5}, {2, 3, 4, 3}, {6, 6}}) {
    const auto levels = plain_levels(sizes);
    const auto pyramid = ParameterPyramid::of(sizes, levels);
    ASSERT_TRUE(pyramid);
    EXPECT_EQ(pyramid->first_image(1 < levels.size() ? 1 : 0), levels.size() > 1 ? 1u : 0u);  // one image at the top
    for (std::size_t l = 0; l < levels.size(); ++l) {
      std::vector<int> served(pyramid->sample_count());
      for (std::size_t i = 0; i < pyramid->image_count(); ++i) {
        if (pyramid->level_of(i) != l) continue;
        const auto samples = pyramid->samples_of(i);
        EXPECT_FALSE(samples.empty());
        for (const std::size_t s : samples) {
          ++served[s];
          if (l > 0) {
            EXPECT_EQ(pyramid->parent_of(i), pyramid->image_of(l - 1, s));
          }
        }
      }
      EXPECT_EQ(std::accumulate(served.begin(), served.end(), 0), static_cast<int>(served.size()));
      EXPECT_EQ(*std::max_element(served.begin(), served.end()), 1);
    }
  }
}

TEST(ParameterPyramid, LinearTermsSumToOneAndReproduceRamps) {
  const auto pyramid = ParameterPyramid::of({8, 5}, {{3, 3}, {1, 1}, {0, 1}, {0, 0}});
  ASSERT_TRUE(pyramid);
  for (std::size_t level = 0; level < pyramid->level_count(); ++level)
    for (std::size_t s = 0; s < pyramid->sample_count(); ++s) {
      double sum = 0.0, ramp = 0.0;
      for (const auto& term : pyramid->terms(level, s, true)) {
        const auto samples = pyramid->samples_of(term.image);
        double middle = 0.0;
        for (const std::size_t of : samples)
          middle += static_cast<double>(of / 5) / static_cast<double>(samples.size());
        EXPECT_EQ(pyramid->level_of(term.image), level);
        sum += static_cast<double>(term.weight);
        ramp += static_cast<double>(term.weight) * middle;
      }
      EXPECT_NEAR(sum, 1.0, 1e-6);
      if (level == 1) {
        EXPECT_NEAR(ramp, std::clamp(static_cast<double>(s / 5), 0.5, 6.5), 1e-6);
      }
    }
}

TEST(ParameterPyramid, RefusesWhatIsNoPyramid) {
  const auto refused = [](std::vector<std::size_t> sizes, std::vector<Halvings> levels) {
    return !ParameterPyramid::of(std::move(sizes), std::move(levels));
  };
  EXPECT_TRUE(refused({}, {{}}));
  EXPECT_TRUE(refused({8}, {}));
  EXPECT_TRUE(refused({0}, {{0}}));
  EXPECT_TRUE(refused({8}, {{3}, {1}}));       // the levels end before the samples
  EXPECT_TRUE(refused({8}, {{1}, {1}, {0}}));  // two equal levels
  EXPECT_TRUE(refused({8, 8}, {{1, 0}, {0, 1}, {0, 0}}));
  EXPECT_TRUE(refused({8, 8}, {{1}, {0}}));
  EXPECT_TRUE(refused({8}, {{200}, {0}}));
  EXPECT_TRUE(refused({60000, 60000}, {{0, 0}}));
  EXPECT_TRUE(refused({std::size_t{1} << 63, 2}, {{0, 0}}));
  EXPECT_FALSE(refused({8}, {{16}, {0}}));
}

TEST(ChosenLevels, FindWhatACostPrefers) {
  // This cost is lowest if the first dimension is split completely before the second dimension. Each level adds a tenth
  // to the cost.
  const auto cost = [](const std::vector<Halvings>& levels) {
    double sum = 0.1 * static_cast<double>(levels.size());
    for (std::size_t l = 1; l < levels.size(); ++l) {
      const double first = levels[l - 1][0] - levels[l][0], second = levels[l - 1][1] - levels[l][1];
      sum += first * second + (levels[l - 1][1] > levels[l][1] && levels[l - 1][0] > 0 ? 1.0 : 0.0);
    }
    return sum;
  };
  EXPECT_EQ(chosen_levels({8, 8}, cost), (std::vector<Halvings>{{3, 3}, {0, 3}, {0, 0}}));
  EXPECT_EQ(chosen_levels({1}, [](const auto&) { return 1.0; }), (std::vector<Halvings>{{0}}));
}

}  // namespace
}  // namespace multum
