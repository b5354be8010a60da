// SPDX-License-Identifier: Apache-2.0
// With h in texels, +X right and +Y up (row 0 on top), normals follow from central differences of second order:
//   dh/dx = (h(column + 1) - h(column - 1)) / 2      dh/dy = (h(row - 1) - h(row + 1)) / 2
//   n = (-dh/dx, -dh/dy, 1) / |..|
// Beyond the border, a periodic map wraps around, a neighbouring tile continues the surface, and black means height
// 0. If there is no data beyond the border (clamp and mirror, or no data), the slope is the difference from the only
// neighbour:
//   dh/dx = h(column + 1) - h(column)   or   h(column) - h(column - 1)
#include "host/formats/image/normals/height_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "host/formats/image/normals/height_dequantize.h"
#include "host/formats/image/normals/height_steps.h"
#include "host/formats/image/normals/normal_decode.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

// Rounds to two significant digits, as a person would write the number.
double rounded(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::round(value / unit) * unit;
}

// Suggests a scale that gives a usual slope. If the size of texels is known and heights are in metres, suggests the
// exact scale.
std::string suggested_scale(const HeightSurface& surface, double slope_rms, bool is_slope_odd,
                            const NormalMapSettings& settings) {
  const RawImageInfo& info = surface.info();
  const auto scale = static_cast<double>(settings.height_scale);
  std::string text;
  if (info.texel_metres > 0.0) {
    const double of_metres = value_unit(info, surface.reading()) / info.texel_metres;
    if (std::abs(scale - of_metres) > 0.01 * of_metres)
      text += fmt::format("; its texels are {:g} m wide, so heights in metres need --height-scale {:.4g}",
                          info.texel_metres, of_metres);
  } else if (is_slope_odd && slope_rms > 0.0) {
    constexpr double kSlopeDefault = 0.5;  // 27 degrees, in the middle of the expected range
    text += fmt::format(
        "; --height-scale {:g} would make it {:g}. If heights and texels are in metres, the exact scale is (metres per "
        "value difference of 1) / (metres per texel)",
        rounded(std::abs(scale) * kSlopeDefault / slope_rms), kSlopeDefault);
  }
  return text;
}

constexpr double kSlopeMin = 0.05, kSlopeMax = 5.0;  // slopes of expected surfaces: 3 to 79 degrees

bool is_odd(double slope_rms) { return slope_rms < kSlopeMin || slope_rms > kSlopeMax; }

// Warns about unusual slopes. The height scale, which is not in the file, may be wrong, or a grey image may not be a
// height field.
void warn_of_doubts(NormalMapReport& report, const HeightSurface& surface, double slope_rms,
                    const NormalMapSettings& settings) {
  const bool is_scale_said = settings.height_scale != 1.0f;  // users never set the default explicitly
  std::string text;
  if (settings.bump_format == BumpFormat::kAuto && surface.reading().coding == HeightCoding::kGrey)
    text = fmt::format("a grey image, read as a height field with a height scale of {:g}{}", settings.height_scale,
                       advice(" (<bumpformat height> confirms it)"));
  if (!text.empty() && is_odd(slope_rms)) text += "; ";
  if (slope_rms > kSlopeMax && !is_scale_said)
    text += fmt::format(
        "no height scale is given, so heights are read in texels, which is almost certainly wrong: the surface would "
        "be {:.1f} degrees steep (rms slope {:.3g} is too steep, expected {:g} to {:g})",
        std::atan(slope_rms) * 180.0 / std::numbers::pi, slope_rms, kSlopeMin, kSlopeMax);
  else if (is_odd(slope_rms))
    text +=
        fmt::format("its rms slope of {:.3g} is too {}, expected {:g} to {:g}, so a height scale of {:g} may be wrong",
                    slope_rms, slope_rms < kSlopeMin ? "flat" : "steep", kSlopeMin, kSlopeMax, settings.height_scale);
  const std::string suggestion = suggested_scale(surface, slope_rms, is_odd(slope_rms), settings);
  if (text.empty() && !suggestion.empty())
    text = fmt::format("a height scale of {:g} may be wrong", settings.height_scale);
  text += suggestion;
  if (!text.empty()) report.warnings.push_back(text);
}

// The sums over one row. Because sums are per row, the total does not depend on the division into bands.
struct RowSums {
  std::int64_t lifted = 0;
  std::int64_t missing = 0;  // texels without a height
  double slopes = 0.0;       // sum of squared slopes
  float low = std::numeric_limits<float>::infinity(),
        high = -std::numeric_limits<float>::infinity();  // range of heights
};

// Returns twice the slope at a texel. The slope follows from both neighbours, or from the only neighbour with a height.
double twice_slope(float before, float at, float after) {
  const bool has_before = !std::isnan(before), has_after = !std::isnan(after);
  const auto difference = [](float a, float b) { return static_cast<double>(a) - static_cast<double>(b); };
  if (has_before && has_after) return difference(after, before);
  if (has_after) return 2.0 * difference(after, at);
  return has_before ? 2.0 * difference(at, before) : 0.0;
}

// Reads rows of dequantized_heights(), beginning with row -1.
HeightRows rows_of(const RawImage& dequantized, int row_begin, int row_end) {
  RawRows raw;
  dequantized.read_rows(row_begin + 1, row_end - row_begin, raw);
  return {-1, row_begin, dequantized.info().width, std::move(raw.values)};
}

// Returns the normals of one row. `heights` also holds the neighbouring rows. A texel without a height is flat.
RowSums row_normals(const HeightRows& heights, int row, int width, double height_scale,
                    const std::array<float*, 3>& normals) {
  const double half_scale = 0.5 * height_scale;
  const float *const above = &heights.row(row - 1)[1], *const own = &heights.row(row)[1],
                     *const below = &heights.row(row + 1)[1];
  RowSums sums;
  for (int column = 0; column < width; ++column) {
    glm::dvec3 n(0.0, 0.0, 1.0);
    if (std::isnan(own[column])) {
      ++sums.missing;
    } else {
      n.x = -half_scale * twice_slope(own[column - 1], own[column], own[column + 1]);
      n.y = -half_scale * twice_slope(below[column], own[column], above[column]);
      sums.slopes += n.x * n.x + n.y * n.y;
      if (!normalise_above_horizon(n)) ++sums.lifted;
      sums.low = std::min(sums.low, own[column]);
      sums.high = std::max(sums.high, own[column]);
    }
    normals[0][column] = static_cast<float>(n.x);
    normals[1][column] = static_cast<float>(n.y);
    normals[2][column] = static_cast<float>(n.z);
  }
  return sums;
}

RowSums& operator+=(RowSums& sums, const RowSums& more) {
  sums.lifted += more.lifted;
  sums.missing += more.missing;
  sums.slopes += more.slopes;
  sums.low = std::min(sums.low, more.low);
  sums.high = std::max(sums.high, more.high);
  return sums;
}

// Writes the normals of a surface, or the normals of `dequantized` heights if these are not null.
RowSums write_normals(const HeightSurface& surface, const RawImage* dequantized, const NormalMapSettings& settings,
                      const SpillPolicy& spill, int threads, Progress* progress, PlaneStore& store) {
  const int width = surface.width(), height = surface.height();
  std::vector<RowSums> sums(static_cast<std::size_t>(height));
  for_each_row_band(height, decoding_rows(width, spill), threads, progress, [&](int, int row_begin, int row_end) {
    const HeightRows rows = dequantized != nullptr ? rows_of(*dequantized, row_begin - 1, row_end + 1)
                                                   : surface.rows(row_begin - 1, row_end + 1, 1);
    std::array<std::vector<float>, 3> normals;
    for (std::vector<float>& plane : normals)
      plane.resize(static_cast<std::size_t>(row_end - row_begin) * static_cast<std::size_t>(width));
    for (int row = row_begin; row < row_end; ++row) {
      const std::size_t first = static_cast<std::size_t>(row - row_begin) * static_cast<std::size_t>(width);
      sums[static_cast<std::size_t>(row)] = row_normals(rows, row, width, static_cast<double>(settings.height_scale),
                                                        {&normals[0][first], &normals[1][first], &normals[2][first]});
    }
    store.write_rows(row_begin, row_end - row_begin, {normals[0].data(), normals[1].data(), normals[2].data()});
  });
  RowSums total;
  for (const RowSums& row : sums) total += row;
  return total;
}

// Warns about steps that turn smooth slopes into terraces.
void warn_of_steps(NormalMapReport& report, const HeightSteps& steps, const HeightSurface& surface,
                   const NormalMapSettings& settings) {
  const auto scale = static_cast<double>(settings.height_scale);
  if (settings.dequantize && steps.step == 0.0)
    report.warnings.push_back("this setting has no effect on heights without steps" + names_as_advice({"dequantize"}));
  if (settings.dequantize || !steps.are_terraces(scale)) return;
  report.warnings.push_back(
      fmt::format("its heights have steps of {}. At a height scale of {:g}, one step tilts a texel by {:.1f} degrees, "
                  "so smooth slopes become terraces. Heights with more bits avoid this{}",
                  step_text(steps, surface), settings.height_scale, steps.degrees(scale),
                  advice("; <dequantize> smooths them within half a step")));
}

// Returns "height field, Terrarium elevation in metres, -12 to 1830, no data on 3.2 % of the texels, scale 30 texels,
// ..."
std::string description(const HeightSurface& surface, const RowSums& sums, double slope_rms,
                        const NormalMapSettings& settings) {
  std::string text = "height field";
  const HeightReading& reading = surface.reading();
  if (reading.coding != HeightCoding::kGrey) text += ", " + height_coding_name(reading.coding);
  text += fmt::format(", scale {:g} texels, rms slope {:.3g}", settings.height_scale, slope_rms);
  const double unit = value_unit(surface.info(), reading);
  if (sums.low <= sums.high)
    text += fmt::format(", values {:.6g} to {:.6g}", unit * static_cast<double>(sums.low),
                        unit * static_cast<double>(sums.high));
  if (unit > 1.0) text += fmt::format(" of {:.10g}", unit);
  if (sums.missing > 0)
    text += fmt::format(
        ", no data{} in {:.3g} % of the texels, which are read as flat",
        reading.no_data ? fmt::format(" ({:.6g})", unit * static_cast<double>(*reading.no_data)) : "",
        100.0 * static_cast<double>(sums.missing) / (static_cast<double>(surface.width()) * surface.height()));
  return text;
}

}  // namespace

NormalMapRows normals_from_heights(const std::string& path, const HeightField& field, const NormalMapSettings& settings,
                                   const SpillPolicy& spill, int threads, Progress* progress) {
  progress_stage(progress, "heights to normals");
  const HeightSurface surface(field.image, field.reading, field.nonfinite_count == 0, settings.fix_nan, field.sides);
  const HeightSteps steps = measure_steps(surface);
  std::optional<RawImage> dequantized;
  if (settings.dequantize && steps.step > 0.0)
    dequantized.emplace(dequantized_heights(surface, steps.step, spill, threads, progress));
  NormalMapRows map{make_plane_store(surface.width(), surface.height(), spill), {}};
  const RowSums sums =
      write_normals(surface, dequantized ? &*dequantized : nullptr, settings, spill, threads, progress, map.normals);
  const double texel_count = static_cast<double>(surface.width()) * surface.height();
  const double slope_rms = std::sqrt(sums.slopes / std::max(1.0, texel_count - static_cast<double>(sums.missing)));
  map.report.encoding = description(surface, sums, slope_rms, settings);
  if (dequantized)
    map.report.encoding += fmt::format(", dequantized within half a step of {}", step_text(steps, surface));
  warn_of_doubts(map.report, surface, slope_rms, settings);
  warn_of_steps(map.report, steps, surface, settings);
  map.report.unused_texels = sums.missing;
  map.report.nonfinite_repaired = field.nonfinite_count;
  map.report.below_horizon_repaired = sums.lifted;
  // Slopes beyond the horizon usually mean a wrong scale.
  check_repair_share(path, map, settings, suggested_scale(surface, slope_rms, is_odd(slope_rms), settings));
  return map;
}

}  // namespace multum
