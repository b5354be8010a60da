// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/normals/image_survey.h"

#include <algorithm>
#include <cmath>

#include <glm/vec3.hpp>

#include "host/formats/image/files/number_type.h"

namespace multum {

namespace {

// Converts a value of the file like SampleConverter. Integers are divided by their largest value.
float converted(double number, int base_type) {
  const auto value = static_cast<float>(number);
  switch (base_type) {
    case number_type::kUint8: return value * (1.0f / 255.0f);
    case number_type::kInt8: return value * (1.0f / 127.0f);
    case number_type::kUint16: return value * (1.0f / 65535.0f);
    case number_type::kInt16: return value * (1.0f / 32767.0f);
    case number_type::kUint32: return value * (1.0f / 4294967295.0f);
    case number_type::kInt32: return value * (1.0f / 2147483647.0f);
    default: return value;
  }
}

}  // namespace

ImageSurvey::ImageSurvey(const RawImageInfo& info, const std::vector<VectorEncoding>& readings)
    : info_(info), converter_(info.base_type) {
  if (info.channel_count == 1 && info.no_data) stated_ = converted(*info.no_data, info.base_type);
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

// Adds a value of an image with one channel.
void ImageSurvey::add_value(float value) {
  if (value == stated_) {
    ++stated_count_;
    return;
  }
  Range& range = ranges_[0];
  if (value < range.low) {
    second_low_ = range.low;
    range.low = value;
    low_count_ = 0;
  } else if (value > range.low) {
    second_low_ = std::min(second_low_, value);
  }
  if (value == range.low) ++low_count_;
  range.high = std::max(range.high, value);
}

// Recognises values that programs write for missing heights without declaring them: the lowest int16 and the next one,
// -9999, and the lowest float. All other heights must be less than half as deep.
std::optional<float> ImageSurvey::no_data() const {
  if (info_.channel_count != 1) return std::nullopt;
  if (stated_) return stated_count_ > 0 ? stated_ : std::nullopt;
  constexpr double kLowestFloats = -1e30;
  const float low = ranges_[0].low;
  if (!(second_low_ > 0.5f * low) || second_low_ == std::numeric_limits<float>::infinity()) return std::nullopt;
  if (is_float_type(info_.sample_type) && static_cast<double>(low) < kLowestFloats) return low;
  const bool is_wide = info_.base_type == number_type::kInt16 || info_.base_type == number_type::kInt32 ||
                       info_.base_type == number_type::kFloat || info_.base_type == number_type::kDouble;
  for (const double usual : {-32768.0, -32767.0, -9999.0})
    if (is_wide && low == converted(usual, info_.base_type)) return low;
  return std::nullopt;
}

ImageSurvey::Range ImageSurvey::range(int channel) const {
  Range range = ranges_[static_cast<std::size_t>(channel)];
  if (channel == 0 && !stated_ && no_data()) range.low = second_low_;
  return range;
}

void ImageSurvey::add_row(int row, const float* values) {
  const auto channel_count = static_cast<std::size_t>(info_.channel_count);
  for (int column = 0; column < info_.width; ++column, values += channel_count) {
    bool is_finite = true, is_nan = true, is_zero = true;
    for (std::size_t c = 0; c < channel_count; ++c) {
      is_nan &= std::isnan(values[c]);
      is_zero &= values[c] == 0.0f;
      if (std::isfinite(values[c]) && channel_count == 1) {
        add_value(values[c]);
      } else if (std::isfinite(values[c])) {
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
    } else if (channel_count > 1) {
      // If there are two channels, adds their mean as a third channel, which has no chroma.
      const glm::dvec3 v(values[0], values[1], channel_count > 2 ? values[2] : 0.5f * (values[0] + values[1]));
      const glm::dvec3 chroma = v - (v.x + v.y + v.z) / 3.0;
      const auto largest = static_cast<float>(std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}));
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
  constexpr double kOutlierShareMax = 0.01;  // like NormalMapSettings::repair_share_max
  ChromaSums all, without_outliers;
  for (const ChromaSums& sums : chroma_) all.add(sums);
  for (const ChromaSums& sums : chroma_)
    if (without_outliers.count < (1.0 - kOutlierShareMax) * all.count) without_outliers.add(sums);
  return {all, without_outliers};
}

// Returns the rms of the values for floats, and 1 for integers.
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
