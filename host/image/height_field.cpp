// SPDX-License-Identifier: Apache-2.0
// With h in texels, +X right and +Y up (row 0 on top), by central differences of second order:
//   dh/dx = (h(column + 1) - h(column - 1)) / 2      dh/dy = (h(row - 1) - h(row + 1)) / 2
//   n = (-dh/dx, -dh/dy, 1) / |..|
// Beyond the border: periodic wraps round; clamp and mirror repeat the border texel (mirrors lie between texels, as in
// OpenImageIO), which halves the slope there; black is height 0.
#include "host/image/height_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/image/normal_decode.h"

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

struct HeightPlane {
  int width;
  int height;
  const std::vector<float>& values;

  double at(int column, int row) const {
    if (column < 0 || row < 0) return 0.0;
    return static_cast<double>(
        values[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)]);
  }
};

double finite_neighbours_mean(const HeightPlane& heights, int column, int row) {
  double sum = 0.0;
  int count = 0;
  for (int y = std::max(0, row - 1); y <= std::min(heights.height - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(heights.width - 1, column + 1); ++x) {
      if (!std::isfinite(heights.at(x, y))) continue;
      sum += heights.at(x, y);
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

// Fills non-finite heights from the unrepaired plane.
void repair_heights(std::vector<float>& values, int width, int height, FixNan fix_nan) {
  std::vector<std::pair<std::size_t, float>> repairs;
  const HeightPlane plane{width, height, values};
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    const auto column = static_cast<int>(i % static_cast<std::size_t>(width));
    const auto row = static_cast<int>(i / static_cast<std::size_t>(width));
    repairs.emplace_back(
        i, fix_nan == FixNan::kBox3 ? static_cast<float>(finite_neighbours_mean(plane, column, row)) : 0.0f);
  }
  for (const auto& [i, value] : repairs) values[i] = value;
}

// Averages the channels into the first plane. Any non-finite channel makes the texel non-finite.
void merge_channels(RawImage& image) {
  if (image.planes.size() == 1) return;
  for (std::size_t i = 0; i < image.planes[0].size(); ++i) {
    double sum = 0.0;
    for (const std::vector<float>& plane : image.planes) sum += static_cast<double>(plane[i]);
    image.planes[0][i] = static_cast<float>(sum / static_cast<double>(image.planes.size()));
  }
  image.planes.resize(1);
}

// A height's scale is not in the file, and a grey image may be none: both show in the slopes.
void warn_of_doubts(NormalMapReport& report, double slope_rms, const NormalMapSettings& settings) {
  constexpr double kSlopeMin = 0.05, kSlopeMax = 5.0;  // surfaces that a bake is for: 3 to 79 degrees
  std::string text;
  if (settings.bump_format == BumpFormat::kAuto)
    text = fmt::format(
        "a grey image, taken for a height field at --height-scale {:g} (--bumpformat height says that "
        "it is one)",
        settings.height_scale);
  if (slope_rms < kSlopeMin || slope_rms > kSlopeMax)
    text += fmt::format("{}its rms slope {:.3g} is too {}, expected {:g} to {:g}: --height-scale {:g} may be wrong",
                        text.empty() ? "" : "; ", slope_rms, slope_rms < kSlopeMin ? "flat" : "steep", kSlopeMin,
                        kSlopeMax, settings.height_scale);
  if (!text.empty()) report.warnings.push_back(text);
}

}  // namespace

NormalMap normals_from_heights(const std::string& path, RawImage image, const NormalMapSettings& settings, int threads,
                               Progress* progress) {
  progress_stage(progress, "heights to normals");
  NormalMap map;
  map.width = image.width;
  map.height = image.height;
  map.report.nonfinite_repaired = check_finite(path, image, settings, threads);
  merge_channels(image);
  if (map.report.nonfinite_repaired > 0) repair_heights(image.planes[0], image.width, image.height, settings.fix_nan);
  const HeightPlane heights{image.width, image.height, image.planes[0]};
  for (std::vector<float>* plane : {&map.x, &map.y, &map.z}) plane->resize(image.planes[0].size());
  const double half_scale = 0.5 * static_cast<double>(settings.height_scale);
  const auto band_count = static_cast<std::size_t>(row_band_count(image.height, kRowsPerBand));
  std::vector<std::int64_t> lifted(band_count, 0);
  std::vector<double> square_sums(band_count, 0.0);
  for_each_row_band(map.height, kRowsPerBand, threads, [&](int band, int row_begin, int row_end) {
    for (int row = row_begin; row < row_end; ++row) {
      const int above = wrapped_index(row - 1, map.height, settings.wrap_t);
      const int below = wrapped_index(row + 1, map.height, settings.wrap_t);
      for (int column = 0; column < map.width; ++column) {
        const int left = wrapped_index(column - 1, map.width, settings.wrap_s);
        const int right = wrapped_index(column + 1, map.width, settings.wrap_s);
        glm::dvec3 n(-half_scale * (heights.at(right, row) - heights.at(left, row)),
                     -half_scale * (heights.at(column, above) - heights.at(column, below)), 1.0);
        square_sums[static_cast<std::size_t>(band)] += n.x * n.x + n.y * n.y;
        if (!normalise_above_horizon(n)) ++lifted[static_cast<std::size_t>(band)];
        const std::size_t i =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(column);
        map.x[i] = static_cast<float>(n.x);
        map.y[i] = static_cast<float>(n.y);
        map.z[i] = static_cast<float>(n.z);
      }
    }
  });
  const double texel_count = static_cast<double>(map.width) * map.height;
  const double slope_rms = std::sqrt(std::accumulate(square_sums.begin(), square_sums.end(), 0.0) / texel_count);
  map.report.encoding =
      fmt::format("height field, scale {:g} texels, rms slope {:.3g}", settings.height_scale, slope_rms);
  warn_of_doubts(map.report, slope_rms, settings);
  for (const std::int64_t count : lifted) map.report.below_horizon_repaired += count;
  check_repair_share(path, map, settings);
  return map;
}

}  // namespace multum
