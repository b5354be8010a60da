// SPDX-License-Identifier: Apache-2.0
#include "host/image/normals/image_survey.h"

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
    bool is_finite = true, is_nan = true, is_zero = true;
    for (std::size_t c = 0; c < channel_count; ++c) {
      is_nan &= std::isnan(values[c]);
      is_zero &= values[c] == 0.0f;
      if (std::isfinite(values[c])) {
        ranges_[c].low = std::min(ranges_[c].low, values[c]);
        ranges_[c].high = std::max(ranges_[c].high, values[c]);
      } else {
        is_finite = false;
      }
    }
    all_nan_count_ += is_nan ? 1 : 0;
    all_zero_count_ += is_zero ? 1 : 0;
    if (!is_finite) {
      if (nonfinite_count_++ == 0) first_nonfinite_ = std::int64_t{row} * info_.width + column;
    } else if (channel_count == 3) {
      const glm::dvec3 v(values[0], values[1], values[2]);
      const glm::dvec3 chroma = v - (v.x + v.y + v.z) / 3.0;
      const float largest = std::max({std::abs(values[0]), std::abs(values[1]), std::abs(values[2])});
      const bool has_exponent = is_float_type(info_.sample_type) && largest > 0.0f;
      const int exponent = has_exponent ? std::ilogb(largest) : kExponentMin;
      ChromaSums& sums = chroma_[static_cast<std::size_t>(exponent - kExponentMin)];
      sums.chroma += chroma.x * chroma.x + chroma.y * chroma.y + chroma.z * chroma.z;
      sums.values += v.x * v.x + v.y * v.y + v.z * v.z;
      sums.count += 3.0;
      sums.grey += v.x + v.y + v.z;
    }
  }
}

void ImageSurvey::ChromaSums::add(const ChromaSums& sums) {
  chroma += sums.chroma;
  values += sums.values;
  count += sums.count;
  grey += sums.grey;
}

std::array<ImageSurvey::ChromaSums, 2> ImageSurvey::chroma_sums() const {
  constexpr double kOutlierShareMax = 0.01;  // as many as may be repaired, NormalMapSettings::repair_share_max
  ChromaSums all, without_outliers;
  for (const ChromaSums& sums : chroma_) all.add(sums);
  for (const ChromaSums& sums : chroma_)
    if (without_outliers.count < (1.0 - kOutlierShareMax) * all.count) without_outliers.add(sums);
  return {all, without_outliers};
}

// Rms of the values of floats, 1 of integers.
double ImageSurvey::unit_of(const ChromaSums& sums) const {
  return is_float_type(info_.sample_type) ? std::sqrt(sums.values / sums.count) : 1.0;
}

double ImageSurvey::chroma_of(const ChromaSums& sums) const {
  if (sums.count == 0.0) return 1.0;
  const double unit = unit_of(sums);
  return unit > 0.0 ? std::sqrt(sums.chroma / sums.count) / unit : 0.0;
}

double ImageSurvey::chroma_rms() const {
  const auto [all, without_outliers] = chroma_sums();
  return std::max(chroma_of(all), chroma_of(without_outliers));
}

double ImageSurvey::grey_deviation() const {
  const auto [all, without_outliers] = chroma_sums();
  const ChromaSums& sums = chroma_of(all) >= chroma_of(without_outliers) ? all : without_outliers;
  if (sums.count == 0.0) return 0.0;
  const double mean = sums.grey / sums.count, unit = unit_of(sums);
  const double variance = (sums.values - sums.chroma) / sums.count - mean * mean;
  return unit > 0.0 ? std::sqrt(std::max(0.0, variance)) / unit : 0.0;
}

std::optional<VectorStatistics> ImageSurvey::statistics(const VectorEncoding& encoding) const {
  for (const VectorStatisticsSums& statistics : statistics_)
    if (statistics.encoding() == encoding) return statistics.result();
  return std::nullopt;
}

}  // namespace multum
