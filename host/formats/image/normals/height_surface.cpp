// SPDX-License-Identifier: Apache-2.0
// Heights beyond the image:
//              above
//         +-----------+
//    left |   image   | right        a corner beyond a strip is unknown: NaN
//         +-----------+
//              below
#include "host/formats/image/normals/height_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "host/formats/image/files/number_type.h"

namespace multum {
namespace {

constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();
using Beyond = HeightSide::Beyond;

int wrapped(int index, int count) { return ((index % count) + count) % count; }

HeightSide side_of(WrapMode mode) {
  switch (mode) {
    case WrapMode::kPeriodic: return {Beyond::kWrapped};
    case WrapMode::kBlack: return {Beyond::kBlack};
    case WrapMode::kClamp:
    case WrapMode::kMirror: return {Beyond::kEnd};
  }
  return {};
}

// Combines the bytes of 8-bit channels into one number; red holds the highest byte.
double number_of_bytes(const float* texel, int byte_count) {
  std::uint32_t number = 0;
  for (int c = 0; c < byte_count; ++c) number = number << 8 | static_cast<std::uint32_t>(texel[c] * 255.0f + 0.5f);
  return number;
}

float packed_height(const float* texel, HeightCoding coding) {
  switch (coding) {
    case HeightCoding::kPacked16: return static_cast<float>(number_of_bytes(texel, 2) / 65535.0);
    case HeightCoding::kPacked24: return static_cast<float>(number_of_bytes(texel, 3) / 16777215.0);
    case HeightCoding::kTerrarium: return static_cast<float>(number_of_bytes(texel, 3) / 256.0 - 32768.0);
    case HeightCoding::kMapbox: return static_cast<float>(number_of_bytes(texel, 3) / 10.0 - 10000.0);
    case HeightCoding::kGrey: break;
  }
  return 0.0f;
}

double finite_neighbours_mean(const HeightRows& heights, int column, int row, int row_end) {
  double sum = 0.0;
  int count = 0;
  for (int y = std::max(heights.row_begin, row - 1); y < std::min(row_end, row + 2); ++y) {
    for (int x = std::max(0, column - 1); x < std::min(heights.row_width, column + 2); ++x) {
      if (!std::isfinite(heights.at(x, y))) continue;
      sum += static_cast<double>(heights.at(x, y));
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

}  // namespace

std::string height_coding_name(HeightCoding coding) {
  switch (coding) {
    case HeightCoding::kPacked16: return "16-bit heights packed in red and green";
    case HeightCoding::kPacked24: return "24-bit heights packed in red, green and blue";
    case HeightCoding::kTerrarium: return "Terrarium elevation in metres";
    case HeightCoding::kMapbox: return "Mapbox terrain-RGB elevation in metres";
    case HeightCoding::kGrey: break;
  }
  return "";
}

double value_unit(const RawImageInfo& info, const HeightReading& reading) {
  if (reading.coding == HeightCoding::kPacked16) return 65535.0;
  if (reading.coding == HeightCoding::kPacked24) return 16777215.0;
  if (reading.coding != HeightCoding::kGrey) return 1.0;
  switch (info.base_type) {
    case number_type::kUint8: return 255.0;
    case number_type::kInt8: return 127.0;
    case number_type::kUint16: return 65535.0;
    case number_type::kInt16: return 32767.0;
    case number_type::kUint32: return 4294967295.0;
    case number_type::kInt32: return 2147483647.0;
    default: return 1.0;
  }
}

HeightSides wrapped_sides(WrapMode wrap_s, WrapMode wrap_t) {
  return {side_of(wrap_s), side_of(wrap_s), side_of(wrap_t), side_of(wrap_t)};
}

HeightSurface::HeightSurface(const RawImage& image, const HeightReading& reading, bool is_finite, FixNan fix_nan,
                             HeightSides sides)
    : image_(image), reading_(reading), is_finite_(is_finite), fix_nan_(fix_nan), sides_(std::move(sides)) {}

// Elevation tiles are black where they have no data. In Terrarium, black would be 32768 m below the sea.
bool HeightSurface::is_no_data(const float* texel, std::size_t channel_count) const {
  if (reading_.coding == HeightCoding::kTerrarium || reading_.coding == HeightCoding::kMapbox)
    return texel[0] == 0.0f && texel[1] == 0.0f && texel[2] == 0.0f;
  return reading_.no_data && channel_count == 1 && texel[0] == *reading_.no_data;
}

// If a channel is not finite, the height becomes infinite, because NaN stands for texels without a height.
HeightRows HeightSurface::merged_rows(int row_begin, int row_end) const {
  RawRows raw;
  image_.read_rows(row_begin, row_end - row_begin, raw);
  const auto channel_count = static_cast<std::size_t>(image_.info().channel_count);
  HeightRows rows{0, row_begin, width(), {}};
  const bool is_grey = reading_.coding == HeightCoding::kGrey;
  if (is_grey && channel_count == 1 && is_finite_ && !reading_.no_data) {
    rows.values = std::move(raw.values);
    return rows;
  }
  rows.values.resize(raw.values.size() / channel_count);
  for (std::size_t i = 0; i < rows.values.size(); ++i) {
    const float* const texel = &raw.values[i * channel_count];
    if (is_no_data(texel, channel_count)) {
      rows.values[i] = kNoHeight;
      continue;
    }
    if (!is_grey) {
      rows.values[i] = packed_height(texel, reading_.coding);
      continue;
    }
    double sum = 0.0;
    for (std::size_t c = 0; c < channel_count; ++c) sum += static_cast<double>(texel[c]);
    const auto mean = static_cast<float>(sum / static_cast<double>(channel_count));
    rows.values[i] = std::isfinite(mean) ? mean : std::numeric_limits<float>::infinity();
  }
  return rows;
}

// Fills in heights that are not finite. For this, it reads the unrepaired rows and one extra row on either side.
HeightRows HeightSurface::repaired_rows(int row_begin, int row_end) const {
  if (is_finite_) return merged_rows(row_begin, row_end);
  const int found_end = std::min(height(), row_end + 1);
  const HeightRows found = merged_rows(std::max(0, row_begin - 1), found_end);
  HeightRows repaired{0, row_begin, found.row_width, {}};
  repaired.values.assign(found.values.begin() + static_cast<std::ptrdiff_t>(found.index(0, row_begin)),
                         found.values.begin() + static_cast<std::ptrdiff_t>(found.index(0, row_end - 1)) + width());
  for (int row = row_begin; row < row_end; ++row) {
    for (int column = 0; column < width(); ++column) {
      if (!std::isinf(found.at(column, row))) continue;
      repaired.values[repaired.index(column, row)] =
          fix_nan_ == FixNan::kBox3 ? static_cast<float>(finite_neighbours_mean(found, column, row, found_end)) : 0.0f;
    }
  }
  return repaired;
}

// Appends one of the rows of the image, with the columns beyond its ends.
void HeightSurface::append_own_row(const float* own, int row, int margin, HeightRows& rows) const {
  const auto append_side = [&](const HeightSide& side, int column_begin) {
    for (int column = column_begin; column < column_begin + margin; ++column) {
      float value = side.beyond == Beyond::kBlack ? 0.0f : kNoHeight;
      if (side.beyond == Beyond::kWrapped) value = own[wrapped(column, width())];
      if (side.beyond == Beyond::kStrip) {
        const int in_strip = column - side.strip->column_begin;
        if (in_strip >= 0 && in_strip < side.strip->row_width) value = side.strip->at(column, row);
      }
      rows.values.push_back(value);
    }
  };
  append_side(sides_.left, -margin);
  rows.values.insert(rows.values.end(), own, own + width());
  append_side(sides_.right, width());
}

// Appends a row above or below the image.
void HeightSurface::append_row(int row, int margin, HeightRows& rows) const {
  const HeightSide& side = row < 0 ? sides_.above : sides_.below;
  if (side.beyond == Beyond::kWrapped) {
    const int own = wrapped(row, height());
    append_own_row(repaired_rows(own, own + 1).values.data(), own, margin, rows);
    return;
  }
  const std::size_t first = rows.values.size();
  rows.values.resize(first + static_cast<std::size_t>(rows.row_width),
                     side.beyond == Beyond::kBlack ? 0.0f : kNoHeight);
  if (side.beyond != Beyond::kStrip) return;
  const int in_strip = row - side.strip->row_begin;
  if (in_strip < 0 || in_strip >= side.strip->row_count()) return;
  std::copy_n(side.strip->row(row), width(), rows.values.begin() + static_cast<std::ptrdiff_t>(first) + margin);
}

HeightRows HeightSurface::rows(int row_begin, int row_end, int margin) const {
  const int own_begin = std::clamp(row_begin, 0, height()), own_end = std::clamp(row_end, own_begin, height());
  if (margin == 0 && own_begin == row_begin && own_end == row_end) return repaired_rows(row_begin, row_end);
  HeightRows rows{-margin, row_begin, width() + 2 * margin, {}};
  rows.values.reserve(static_cast<std::size_t>(row_end - row_begin) * static_cast<std::size_t>(rows.row_width));
  for (int row = row_begin; row < own_begin; ++row) append_row(row, margin, rows);
  if (own_begin < own_end) {
    const HeightRows own = repaired_rows(own_begin, own_end);
    for (int row = own_begin; row < own_end; ++row) append_own_row(own.row(row), row, margin, rows);
  }
  for (int row = std::max(own_end, row_begin); row < row_end; ++row) append_row(row, margin, rows);
  return rows;
}

}  // namespace multum
