// SPDX-License-Identifier: Apache-2.0
// Collects statistics of an image while it is read, so that the image does not have to be read again. The statistics
// are counts of non-finite values, greyness, ranges, and statistics of the values as vectors.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "host/formats/image/normals/vector_statistics.h"
#include "host/formats/image/raw_image.h"

namespace multum {

class ImageSurvey {
 public:
  /// `readings` lists the ways to interpret the values. Statistics are collected for each of them.
  ImageSurvey(const RawImageInfo& info, const std::vector<VectorEncoding>& readings);

  /// Adds a band. The bands must come in order from the top.
  void add(const RawBand& band);

  struct Range {
    float low = std::numeric_limits<float>::infinity();
    float high = -std::numeric_limits<float>::infinity();  // less than `low` until there is a finite value
  };
  /// Returns the range of the finite values of a channel. In images with one channel, the range excludes no_data().
  Range range(int channel) const;
  /// For images with one channel, returns the value of texels without data, as converted by SampleConverter. If the
  /// file does not state this value, the lowest value is used, provided that it is one of the usual values and far
  /// below all other values.
  std::optional<float> no_data() const;
  std::int64_t no_data_count() const { return no_data() ? stated_count_ + (stated_ ? 0 : low_count_) : 0; }
  /// Return the number of texels with a channel that is NaN or infinite, and the index of the first one, counted row by
  /// row.
  std::int64_t nonfinite_count() const { return nonfinite_count_; }
  std::int64_t first_nonfinite() const { return first_nonfinite_; }
  /// Return the number of texels whose channels are all NaN, and the number of texels whose channels are all 0.
  std::int64_t all_nan_count() const { return all_nan_count_; }
  std::int64_t all_zero_count() const { return all_zero_count_; }
  /// Returns the rms distance of three channels from their mean, over the finite texels, or 1 if none is finite. For
  /// floats, it is relative to the rms of the values, because a height in metres and a dim photograph have different
  /// scales. For integers, it is relative to the whole range. The result is the larger of two values: one for all
  /// texels, and one without the 1 % largest values, so that a few outliers cannot hide the other texels.
  double chroma_rms() const;
  /// Returns the standard deviation of the mean of the channels, in the same unit and over the same texels as
  /// chroma_rms().
  double grey_deviation() const;
  /// Returns the statistics of one of `readings`, or nullopt for other readings.
  std::optional<VectorStatistics> statistics(const VectorEncoding& encoding) const;

 private:
  void add_row(int row, const float* values);
  void add_value(float value);

  RawImageInfo info_;
  SampleConverter converter_;
  std::array<Range, 3> ranges_;
  // For images with one channel. If the file states a value for texels without data, this object holds that value and
  // its count. Otherwise, it holds the lowest value, its count, and the second lowest value.
  std::optional<float> stated_;
  std::int64_t stated_count_ = 0, low_count_ = 0;
  float second_low_ = std::numeric_limits<float>::infinity();
  std::int64_t nonfinite_count_ = 0;
  std::int64_t first_nonfinite_ = -1;
  std::int64_t all_nan_count_ = 0;
  std::int64_t all_zero_count_ = 0;
  struct ChromaSums {
    double chroma = 0.0, values = 0.0, count = 0.0;  // sums of squares, and the number of values
    double grey = 0.0;                               // sum of three times the mean of the channels
    void add(const ChromaSums& sums);
  };
  // Sums over all texels, and without the 1 % largest values.
  std::array<ChromaSums, 2> chroma_sums() const;
  double unit_of(const ChromaSums& sums) const;
  double chroma_of(const ChromaSums& sums) const;
  // Floats are summed separately for each binary exponent of the texel's largest value, from -149 to 127. Integers are
  // summed all together.
  static constexpr int kExponentMin = -149, kExponentCount = 278;
  std::array<ChromaSums, kExponentCount> chroma_;
  std::vector<VectorStatisticsSums> statistics_;
};

}  // namespace multum
