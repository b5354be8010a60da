// SPDX-License-Identifier: Apache-2.0
#include "host/image/image_survey.h"

#include <algorithm>
#include <cmath>

#include <glm/vec3.hpp>

namespace multum {

ImageSurvey::ImageSurvey(const RawImageInfo& info, const std::vector<VectorEncoding>& readings)
    : info_(info), converter_(info.base_type) {
  for (const VectorEncoding& encoding : readings) statistics_.emplace_back(info, encoding);
}

void ImageSurvey::add(const RawBand& band) {
  std::vector<float> values(info_.row_values());
  for (int row = 0; row < band.row_count; ++row) {
    converter_.convert(band.samples + info_.row_bytes * static_cast<std::size_t>(row), values.size(), values.data());
    add_row(band.first_row + row, values.data());
    for (VectorStatisticsSums& statistics : statistics_) statistics.add_row(values.data());
  }
}

void ImageSurvey::add_row(int row, const float* values) {
  const auto channel_count = static_cast<std::size_t>(info_.channel_count);
  for (int column = 0; column < info_.width; ++column, values += channel_count) {
    bool is_finite = true;
    for (std::size_t c = 0; c < channel_count; ++c) {
      if (std::isfinite(values[c])) {
        ranges_[c].low = std::min(ranges_[c].low, values[c]);
        ranges_[c].high = std::max(ranges_[c].high, values[c]);
      } else {
        is_finite = false;
      }
    }
    if (!is_finite) {
      if (nonfinite_count_++ == 0) first_nonfinite_ = std::int64_t{row} * info_.width + column;
    } else if (channel_count == 3) {
      const glm::dvec3 v(values[0], values[1], values[2]);
      const glm::dvec3 chroma = v - (v.x + v.y + v.z) / 3.0;
      chroma_sum_ += chroma.x * chroma.x + chroma.y * chroma.y + chroma.z * chroma.z;
      value_sum_ += v.x * v.x + v.y * v.y + v.z * v.z;
      value_count_ += 3.0;
    }
  }
}

double ImageSurvey::chroma_rms() const {
  if (value_count_ == 0.0) return 1.0;
  if (!is_float_type(info_.sample_type)) return std::sqrt(chroma_sum_ / value_count_);
  return value_sum_ > 0.0 ? std::sqrt(chroma_sum_ / value_sum_) : 0.0;
}

std::optional<VectorStatistics> ImageSurvey::statistics(const VectorEncoding& encoding) const {
  for (const VectorStatisticsSums& statistics : statistics_)
    if (statistics.encoding() == encoding) return statistics.result();
  return std::nullopt;
}

}  // namespace multum
