// SPDX-License-Identifier: Apache-2.0
// Collects statistics of an image while it is read, so that its numbers need not be read again: finite or not, how
// grey, between which bounds, and how they look as vectors.
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
  /// `readings`: of what the numbers may mean, the ones whose statistics are taken.
  ImageSurvey(const RawImageInfo& info, const std::vector<VectorEncoding>& readings);

  /// Adds a band; all come, in order, from the top.
  void add(const RawBand& band);

  struct Range {
    float low = std::numeric_limits<float>::infinity();
    float high = -std::numeric_limits<float>::infinity();  // below `low` while nothing is finite
  };
  /// Range of a channel's finite values; of images of one channel without no_data().
  Range range(int channel) const;
  /// Of images of one channel: the value that says that a texel has none, as SampleConverter gives it. Where the file
  /// does not name it, it is the lowest, one of those that are usual for it, and far below all others.
  std::optional<float> no_data() const;
  std::int64_t no_data_count() const { return no_data() ? stated_count_ + (stated_ ? 0 : low_count_) : 0; }
  /// Texels of which a channel is NaN or infinite, and the first of them, by rows.
  std::int64_t nonfinite_count() const { return nonfinite_count_; }
  std::int64_t first_nonfinite() const { return first_nonfinite_; }
  /// Texels of which every channel is NaN, and those of which every channel is 0.
  std::int64_t all_nan_count() const { return all_nan_count_; }
  std::int64_t all_zero_count() const { return all_zero_count_; }
  /// Rms distance of three channels from their mean, over the finite texels. For floats relative to the rms of the
  /// values (a height in metres and a dim photograph both have their own scale), for integers in units of the whole
  /// range; the larger of that over all texels and that without the 1 % of the largest values, so that a few outliers
  /// cannot hide what all others are. 1 where nothing is finite.
  double chroma_rms() const;
  /// Standard deviation of the channels' mean, in the same unit and of the same texels as what chroma_rms() is of.
  double grey_deviation() const;
  /// Statistics of one of `readings`; nullopt for others.
  std::optional<VectorStatistics> statistics(const VectorEncoding& encoding) const;

 private:
  void add_row(int row, const float* values);
  void add_value(float value);

  RawImageInfo info_;
  SampleConverter converter_;
  std::array<Range, 3> ranges_;
  // In images of one channel: what the file says of texels without a value, and their number; else the lowest value,
  // how often it comes, and the lowest of all others.
  std::optional<float> stated_;
  std::int64_t stated_count_ = 0, low_count_ = 0;
  float second_low_ = std::numeric_limits<float>::infinity();
  std::int64_t nonfinite_count_ = 0;
  std::int64_t first_nonfinite_ = -1;
  std::int64_t all_nan_count_ = 0;
  std::int64_t all_zero_count_ = 0;
  struct ChromaSums {
    double chroma = 0.0, values = 0.0, count = 0.0;  // squares
    double grey = 0.0;                               // three times the channels' mean
    void add(const ChromaSums& sums);
  };
  // Of all texels, and of those without the 1 % of the largest values.
  std::array<ChromaSums, 2> chroma_sums() const;
  double unit_of(const ChromaSums& sums) const;
  double chroma_of(const ChromaSums& sums) const;
  // Of floats by the binary exponent of the texel's largest value, from -149 to 127; of integers together.
  static constexpr int kExponentMin = -149, kExponentCount = 278;
  std::array<ChromaSums, kExponentCount> chroma_;
  std::vector<VectorStatisticsSums> statistics_;
};

}  // namespace multum
