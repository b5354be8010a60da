// SPDX-License-Identifier: Apache-2.0
// What is found out of an image while it is read, so that its numbers need not be gone through again: finite or not,
// how grey, between which bounds, and what they look like as vectors.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "host/image/raw_image.h"
#include "host/image/vector_statistics.h"

namespace multum {

class ImageSurvey {
 public:
  /// `readings`: of what the numbers may mean, the ones whose statistics are taken.
  ImageSurvey(const RawImageInfo& info, const std::vector<VectorEncoding>& readings);

  /// All bands, in order, from the top.
  void add(const RawBand& band);

  struct Range {
    float low = std::numeric_limits<float>::infinity();
    float high = -std::numeric_limits<float>::infinity();  // below `low` while nothing is finite
  };
  /// Of a channel's finite values.
  const Range& range(int channel) const { return ranges_[static_cast<std::size_t>(channel)]; }
  /// Texels of which a channel is NaN or infinite, and the first of them, by rows.
  std::int64_t nonfinite_count() const { return nonfinite_count_; }
  std::int64_t first_nonfinite() const { return first_nonfinite_; }
  /// Rms distance of three channels from their mean, over the finite texels. For floats relative to the rms of the
  /// values (a height in metres and a dim photograph both have their own scale), for integers in units of the whole
  /// range. 1 where nothing is finite.
  double chroma_rms() const;
  /// Of one of `readings`; nullopt for others.
  std::optional<VectorStatistics> statistics(const VectorEncoding& encoding) const;

 private:
  void add_row(int row, const float* values);

  RawImageInfo info_;
  SampleConverter converter_;
  std::array<Range, 3> ranges_;
  std::int64_t nonfinite_count_ = 0;
  std::int64_t first_nonfinite_ = -1;
  double chroma_sum_ = 0.0, value_sum_ = 0.0, value_count_ = 0.0;  // squares
  std::vector<VectorStatisticsSums> statistics_;
};

}  // namespace multum
