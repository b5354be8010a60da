// SPDX-License-Identifier: Apache-2.0
// Chooses the points where a pyramid's error is measured: texels spread evenly at random over each level, and points
// around them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/bakes/accuracy/texel_selection.h"

namespace multum {

/// Where in the pyramid the model is evaluated.
enum class AccuracyPoint {
  kCentre,   // texel centres: no filtering
  kMidX,     // midway between a texel and its right neighbour
  kMidY,     // midway between a texel and the one below
  kBetween,  // a texel's centre, half-way to the next coarser level (bilinear there)
};
constexpr int kAccuracyPointKinds = 4;
const char* accuracy_point_name(AccuracyPoint point);

struct AccuracySample {
  int level;
  int texel;
  int cell_texels;  // that it stands for, itself included: its weight in sums over the level; 1 where all are samples
};

/// A point as weighted texels: one for a centre, two midway, up to five between levels.
struct SamplePoint {
  AccuracyPoint kind;
  std::size_t sample;  // its number among AccuracyPoints::samples()
  std::array<std::size_t, 5> slots;
  std::array<double, 5> weights;
  int tap_count;
};

/// A grid of cells of 2 x 2 texels, which thin levels cut off, would save too little to be worth an interval: a bake
/// takes 0.04 s of processor time more at most (docs/contributing/ALGORITHMS.md, "Measured error").
constexpr int kWholeLevelFactor = 4;

struct SampleSettings {
  int first_level = 0;  // finer ones have no samples
  // About; 0: every texel. Levels of at most kWholeLevelFactor times as many texels have all of them as samples.
  std::int64_t samples_per_level = 2048;
  std::uint64_t seed = 1;
};

class AccuracyPoints {
 public:
  AccuracyPoints(const std::vector<PlaneSize>& levels, const SampleSettings& settings);

  /// Level by level, the finest first.
  const std::vector<AccuracySample>& samples() const { return samples_; }
  /// Those before this number are of levels that are sampled; of later ones every texel is a sample.
  std::size_t chosen_count() const { return chosen_count_; }
  /// All texels that any point reads.
  const TexelSelection& texels() const { return texels_; }
  /// Appends the points of a sample. At borders there are fewer.
  void append_points(std::size_t sample, std::vector<SamplePoint>& points) const;

 private:
  std::vector<AccuracySample> samples_;
  std::size_t chosen_count_ = 0;
  TexelSelection texels_;
};

}  // namespace multum
