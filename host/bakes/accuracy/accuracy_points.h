// SPDX-License-Identifier: Apache-2.0
// Chooses the points where a pyramid's error is measured. The points are texels, which are spread evenly at random over
// each level, and places around these texels.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/bakes/accuracy/texel_selection.h"

namespace multum {

/// The positions in the pyramid at which the model is evaluated.
enum class AccuracyPoint {
  kCentre,   // texel centres: no filtering
  kMidX,     // midway between a texel and its right neighbour
  kMidY,     // midway between a texel and the one below
  kBetween,  // a texel's centre, half-way to the next coarser level; that level is read with bilinear filtering
};
constexpr int kAccuracyPointKinds = 4;
const char* accuracy_point_name(AccuracyPoint point);

struct AccuracySample {
  int level;
  int texel;
  int cell_texels;  // number of texels in the sample's cell, which is the sample's weight in sums; 1 if all texels are
                    // samples
};

/// A point is a list of weighted texels. A centre has one texel, a midpoint has two, and a point between levels has up
/// to five.
struct SamplePoint {
  AccuracyPoint kind;
  std::size_t sample;  // index into AccuracyPoints::samples()
  std::array<std::size_t, 5> slots;
  std::array<double, 5> weights;
  int tap_count;
};

/// A level is measured completely if its texel count is at most this factor times the wanted number of samples.
/// Sampling one of every 2 x 2 texels would save too little time to justify a confidence interval.
constexpr int kWholeLevelFactor = 4;

struct SampleSettings {
  int first_level = 0;  // finer levels have no samples
  // Approximate number of samples. 0 means every texel. Levels with at most kWholeLevelFactor times as many texels use
  // all of them.
  std::int64_t samples_per_level = 2048;
  std::uint64_t seed = 1;
};

class AccuracyPoints {
 public:
  AccuracyPoints(const std::vector<PlaneSize>& levels, const SampleSettings& settings);

  /// Returns the samples, ordered from the finest level to the coarsest.
  const std::vector<AccuracySample>& samples() const { return samples_; }
  /// Returns the number of samples in sampled levels. These samples come first. In the remaining levels, every texel is
  /// a sample.
  std::size_t chosen_count() const { return chosen_count_; }
  /// All texels that are read by at least one point.
  const TexelSelection& texels() const { return texels_; }
  /// Appends the points of a sample. Samples at borders have fewer points.
  void append_points(std::size_t sample, std::vector<SamplePoint>& points) const;

 private:
  std::vector<AccuracySample> samples_;
  std::size_t chosen_count_ = 0;
  TexelSelection texels_;
};

}  // namespace multum
