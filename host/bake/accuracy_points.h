// SPDX-License-Identifier: Apache-2.0
// Where a pyramid's error is measured: texels spread evenly at random over each level, and the points around them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/bake/texel_selection.h"

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
};

/// A point as weighted texels: one for a centre, two midway, up to five between levels.
struct SamplePoint {
  AccuracyPoint kind;
  std::size_t sample;  // its number among AccuracyPoints::samples()
  std::array<std::size_t, 5> slots;
  std::array<double, 5> weights;
  int tap_count;
};

struct SampleSettings {
  int first_level = 0;                    // finer ones have no samples
  std::int64_t samples_per_level = 2048;  // about; 0: every texel
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
