// SPDX-License-Identifier: Apache-2.0
// With h in texels, +X right and +Y up (row 0 on top), by central differences of second order:
//   dh/dx = (h(column + 1) - h(column - 1)) / 2      dh/dy = (h(row - 1) - h(row + 1)) / 2
//   n = (-dh/dx, -dh/dy, 1) / |..|
// Beyond the border: periodic wraps round; clamp and mirror repeat the border texel (mirrors lie between texels, as in
// OpenImageIO), which halves the slope there; black is height 0.
#include "host/image/normals/height_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/processes/parallel.h"
#include "host/image/files/number_type.h"
#include "host/image/normals/normal_decode.h"

namespace multum {
namespace {

// The texel that `index` (-1 .. count) stands for, or -1 for black.
int wrapped_index(int index, int count, WrapMode mode) {
  if (index >= 0 && index < count) return index;
  switch (mode) {
    case WrapMode::kPeriodic: return (index + count) % count;
    case WrapMode::kClamp:
    case WrapMode::kMirror: return std::clamp(index, 0, count - 1);
    case WrapMode::kBlack: return -1;
  }
  return -1;
}

// Rows [row_begin, row_end) of heights.
struct HeightRows {
  int width;
  int row_begin;
  int row_end;
  std::vector<float> values;

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row - row_begin) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  }
  double at(int column, int row) const { return static_cast<double>(values[index(column, row)]); }
};

// The mean of the channels. Any non-finite channel makes the texel non-finite.
HeightRows merged_rows(const RawImage& image, int row_begin, int row_end) {
  RawRows raw;
  image.read_rows(row_begin, row_end - row_begin, raw);
  const auto channel_count = static_cast<std::size_t>(image.info().channel_count);
  if (channel_count == 1) return {image.info().width, row_begin, row_end, std::move(raw.values)};
  HeightRows rows{image.info().width, row_begin, row_end, std::vector<float>(raw.values.size() / channel_count)};
  for (std::size_t i = 0; i < rows.values.size(); ++i) {
    double sum = 0.0;
    for (std::size_t c = 0; c < channel_count; ++c) sum += static_cast<double>(raw.values[i * channel_count + c]);
    rows.values[i] = static_cast<float>(sum / static_cast<double>(channel_count));
  }
  return rows;
}

double finite_neighbours_mean(const HeightRows& heights, int column, int row) {
  double sum = 0.0;
  int count = 0;
  for (int y = std::max(heights.row_begin, row - 1); y < std::min(heights.row_end, row + 2); ++y) {
    for (int x = std::max(0, column - 1); x < std::min(heights.width, column + 2); ++x) {
      if (!std::isfinite(heights.at(x, y))) continue;
      sum += heights.at(x, y);
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

// What is the same for every band.
struct Heights {
  const RawImage& image;
  bool is_finite;
  const NormalMapSettings& settings;

  HeightRows repaired_rows(int row_begin, int row_end) const;
  HeightRows rows_and_neighbours(int row_begin, int row_end) const;
};

// Non-finite heights are filled from rows that are not repaired, one more on either side.
HeightRows Heights::repaired_rows(int row_begin, int row_end) const {
  if (is_finite) return merged_rows(image, row_begin, row_end);
  const HeightRows found = merged_rows(image, std::max(0, row_begin - 1), std::min(image.info().height, row_end + 1));
  HeightRows repaired{found.width, row_begin, row_end, {}};
  repaired.values.assign(found.values.begin() + static_cast<std::ptrdiff_t>(found.index(0, row_begin)),
                         found.values.begin() + static_cast<std::ptrdiff_t>(found.index(0, row_end)));
  for (int row = row_begin; row < row_end; ++row) {
    for (int column = 0; column < found.width; ++column) {
      if (std::isfinite(found.at(column, row))) continue;
      repaired.values[repaired.index(column, row)] =
          settings.fix_nan == FixNan::kBox3 ? static_cast<float>(finite_neighbours_mean(found, column, row)) : 0.0f;
    }
  }
  return repaired;
}

// Rows [row_begin - 1, row_end + 1), where a row beyond the image is the one that the wrap mode puts there.
HeightRows Heights::rows_and_neighbours(int row_begin, int row_end) const {
  const int height = image.info().height;
  HeightRows rows{image.info().width, row_begin - 1, row_end + 1, {}};
  const auto append = [&rows](const HeightRows& next) {
    rows.values.insert(rows.values.end(), next.values.begin(), next.values.end());
  };
  const auto append_beyond = [&](int row) {
    const int wrapped = wrapped_index(row, height, settings.wrap_t);
    if (wrapped >= 0) append(repaired_rows(wrapped, wrapped + 1));
    else rows.values.resize(rows.values.size() + static_cast<std::size_t>(rows.width), 0.0f);
  };
  if (row_begin == 0) append_beyond(-1);
  append(repaired_rows(std::max(0, row_begin - 1), std::min(height, row_end + 1)));
  if (row_end == height) append_beyond(height);
  return rows;
}

// A number with two significant digits, as one would type it.
double rounded(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::round(value / unit) * unit;
}

// What a value difference of 1 is in the file's own numbers: integers were divided by it.
double value_unit(const RawImageInfo& info) {
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

// The scale that a usual slope, or texels of a known size and heights in metres, ask for.
std::string suggested_scale(const RawImageInfo& info, double slope_rms, bool is_slope_odd,
                            const NormalMapSettings& settings) {
  const auto scale = static_cast<double>(settings.height_scale);
  std::string text;
  if (info.texel_metres > 0.0) {
    const double of_metres = value_unit(info) / info.texel_metres;
    if (std::abs(scale - of_metres) > 0.01 * of_metres)
      text += fmt::format("; its texels are {:g} m wide: heights in metres need --height-scale {:.4g}",
                          info.texel_metres, of_metres);
  } else if (is_slope_odd && slope_rms > 0.0) {
    constexpr double kSlopeDefault = 0.5;  // 27 degrees, in the middle of what is expected
    text += fmt::format(
        "; --height-scale {:g} would make it {:g}. Heights and texels in metres give it exactly: metres of a value "
        "difference of 1 / metres of a texel",
        rounded(std::abs(scale) * kSlopeDefault / slope_rms), kSlopeDefault);
  }
  return text;
}

constexpr double kSlopeMin = 0.05, kSlopeMax = 5.0;  // surfaces that a bake is for: 3 to 79 degrees

bool is_odd(double slope_rms) { return slope_rms < kSlopeMin || slope_rms > kSlopeMax; }

// A height's scale is not in the file, and a grey image may be none: both show in the slopes.
void warn_of_doubts(NormalMapReport& report, const RawImageInfo& info, double slope_rms,
                    const NormalMapSettings& settings) {
  const bool is_scale_said = settings.height_scale != 1.0f;  // nobody says the default
  std::string text;
  if (settings.bump_format == BumpFormat::kAuto)
    text = fmt::format(
        "a grey image, taken for a height field at --height-scale {:g} (--bumpformat height says that "
        "it is one)",
        settings.height_scale);
  if (!text.empty() && is_odd(slope_rms)) text += "; ";
  if (slope_rms > kSlopeMax && !is_scale_said)
    text += fmt::format(
        "no --height-scale is given, so heights are taken in texels, which is almost certainly wrong: the surface "
        "would be {:.1f} degrees steep (rms slope {:.3g} is too steep, expected {:g} to {:g})",
        std::atan(slope_rms) * 180.0 / std::numbers::pi, slope_rms, kSlopeMin, kSlopeMax);
  else if (is_odd(slope_rms))
    text +=
        fmt::format("its rms slope {:.3g} is too {}, expected {:g} to {:g}: --height-scale {:g} may be wrong",
                    slope_rms, slope_rms < kSlopeMin ? "flat" : "steep", kSlopeMin, kSlopeMax, settings.height_scale);
  const std::string suggestion = suggested_scale(info, slope_rms, is_odd(slope_rms), settings);
  if (text.empty() && !suggestion.empty())
    text = fmt::format("--height-scale {:g} may be wrong", settings.height_scale);
  text += suggestion;
  if (!text.empty()) report.warnings.push_back(text);
}

// What one row gives, row by row: sums do not depend on how rows were put into bands.
struct RowSums {
  std::int64_t lifted = 0;
  double slopes = 0.0;  // squares
};

// The normals of one row, whose neighbours `heights` holds.
RowSums row_normals(const HeightRows& heights, int row, const NormalMapSettings& settings,
                    const std::array<float*, 3>& normals) {
  const double half_scale = 0.5 * static_cast<double>(settings.height_scale);
  const auto side_height = [&](int column) {
    const int wrapped = wrapped_index(column, heights.width, settings.wrap_s);
    return wrapped >= 0 ? heights.at(wrapped, row) : 0.0;
  };
  RowSums sums;
  for (int column = 0; column < heights.width; ++column) {
    glm::dvec3 n(-half_scale * (side_height(column + 1) - side_height(column - 1)),
                 -half_scale * (heights.at(column, row - 1) - heights.at(column, row + 1)), 1.0);
    sums.slopes += n.x * n.x + n.y * n.y;
    if (!normalise_above_horizon(n)) ++sums.lifted;
    normals[0][column] = static_cast<float>(n.x);
    normals[1][column] = static_cast<float>(n.y);
    normals[2][column] = static_cast<float>(n.z);
  }
  return sums;
}

}  // namespace

NormalMapRows normals_from_heights(const std::string& path, const RawImage& image, std::int64_t nonfinite_count,
                                   const NormalMapSettings& settings, const SpillPolicy& spill, int threads,
                                   Progress* progress) {
  progress_stage(progress, "heights to normals");
  const int width = image.info().width;
  const int height = image.info().height;
  const Heights heights{image, nonfinite_count == 0, settings};
  NormalMapRows map{make_plane_store(width, height, spill), {}};
  std::vector<RowSums> sums(static_cast<std::size_t>(height));
  for_each_row_band(height, decoding_rows(width, spill), threads, progress, [&](int, int row_begin, int row_end) {
    const HeightRows rows = heights.rows_and_neighbours(row_begin, row_end);
    std::array<std::vector<float>, 3> normals;
    for (std::vector<float>& plane : normals) plane.resize(rows.index(0, row_end) - rows.index(0, row_begin));
    for (int row = row_begin; row < row_end; ++row) {
      const std::size_t first = rows.index(0, row) - rows.index(0, row_begin);
      sums[static_cast<std::size_t>(row)] =
          row_normals(rows, row, settings, {&normals[0][first], &normals[1][first], &normals[2][first]});
    }
    map.normals.write_rows(row_begin, row_end - row_begin, {normals[0].data(), normals[1].data(), normals[2].data()});
  });
  RowSums total;
  for (const RowSums& row : sums) {
    total.lifted += row.lifted;
    total.slopes += row.slopes;
  }
  const double slope_rms = std::sqrt(total.slopes / (static_cast<double>(width) * height));
  map.report.encoding =
      fmt::format("height field, scale {:g} texels, rms slope {:.3g}", settings.height_scale, slope_rms);
  warn_of_doubts(map.report, image.info(), slope_rms, settings);
  map.report.nonfinite_repaired = nonfinite_count;
  map.report.below_horizon_repaired = total.lifted;
  // Slopes beyond the horizon are most often a matter of the scale.
  check_repair_share(path, map, settings, suggested_scale(image.info(), slope_rms, is_odd(slope_rms), settings));
  return map;
}

}  // namespace multum
