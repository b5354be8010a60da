// SPDX-License-Identifier: Apache-2.0
// A map that tiles is as continuous across its border as inside. Any other map has a jump at its border. If the texels
// of such a map are independent of each other, the jump is neither detectable nor visible. Tiles and bricks have lines
// along the border, which also occur as steps inside the map. Therefore the border is also compared with the largest
// step inside.
#include "host/formats/image/normals/seam.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace multum {
namespace {

constexpr int kRowsMax = 512;
constexpr int kStepsMin = 15;    // smallest number of steps inside; with fewer, the usual step is unknown
constexpr double kPairsMin = 8;  // smallest number of texel pairs for the rms of a step

// Sums of squares over the channels of finite texels.
struct Sum {
  double squares = 0.0;
  double count = 0.0;

  void add(const float* a, const float* b, std::size_t channel_count) {
    double sum = 0.0;
    for (std::size_t c = 0; c < channel_count; ++c) {
      const double difference = static_cast<double>(a[c]) - static_cast<double>(b[c]);
      sum += difference * difference;
    }
    if (!std::isfinite(sum)) return;
    squares += sum;
    count += 1.0;
  }
  double rms() const { return count > 0.0 ? std::sqrt(squares / count) : 0.0; }
};

SeamStep step_of(const Sum& border, const std::vector<Sum>& inside) {
  std::vector<double> steps;
  for (const Sum& sum : inside)
    if (sum.count > 0.0) steps.push_back(sum.rms());
  if (border.count < kPairsMin || steps.size() < kStepsMin) return {};
  std::sort(steps.begin(), steps.end());
  return {border.rms(), steps[steps.size() / 2], steps.back()};
}

struct SeamSums {
  std::size_t width, channel_count;
  std::vector<Sum> columns, rows;  // steps inside the map
  Sum column_border, row_border;

  SeamSums(std::size_t map_width, std::size_t count) : width(map_width), channel_count(count), columns(map_width - 1) {}
  void add_row(const float* values) {
    for (std::size_t c = 0; c + 1 < width; ++c)
      columns[c].add(values + c * channel_count, values + (c + 1) * channel_count, channel_count);
  }
  void add_rows(const float* upper, const float* lower, Sum& sum) const {
    for (std::size_t i = 0; i < width; ++i)
      sum.add(upper + i * channel_count, lower + i * channel_count, channel_count);
  }
  MapSeams result() const { return {step_of(column_border, columns), step_of(row_border, rows)}; }
};

}  // namespace

// These values were measured on both directions of 55 real maps. In maps that tile, the step at the border is at most
// 1.35 times the largest step inside. In the map with this value, the step at the border is 1.8 times the median step.
// In other maps (terrain, photographs), the step at the border is at least 1.46 times the largest step inside, and at
// least 1.9 times the median step. Maps with hard lines along the border can be below these values, although they do
// not tile.
bool SeamStep::is_seam() const { return border > 1.85 * median && border > 1.4 * largest; }

MapSeams measure_seams(const RawImage& image) {
  const RawImageInfo& info = image.info();
  const auto width = static_cast<std::size_t>(info.width), channel_count = static_cast<std::size_t>(info.channel_count);
  SeamSums sums(width, channel_count);
  RawRows pair, first;
  const int count = std::min(kRowsMax, info.height);
  for (int i = 0; i < count; ++i) {
    const int row = static_cast<int>(static_cast<std::int64_t>(i) * info.height / count);
    image.read_rows(row, std::min(2, info.height - row), pair);
    const float* const values = pair.values.data();
    sums.add_row(values);
    sums.column_border.add(values + (width - 1) * channel_count, values, channel_count);
    if (row + 1 < info.height) sums.add_rows(values, values + width * channel_count, sums.rows.emplace_back());
  }
  image.read_rows(0, 1, first);
  image.read_rows(info.height - 1, 1, pair);
  sums.add_rows(pair.values.data(), first.values.data(), sums.row_border);
  return sums.result();
}

MapSeams measure_seams(const HeightSurface& surface) {
  const auto width = static_cast<std::size_t>(surface.width());
  SeamSums sums(width, 1);
  const int height = surface.height(), count = std::min(kRowsMax, height);
  for (int i = 0; i < count; ++i) {
    const int row = static_cast<int>(static_cast<std::int64_t>(i) * height / count);
    const HeightRows pair = surface.rows(row, std::min(row + 2, height), 1);
    const float* const values = pair.row(row) + 1;
    sums.add_row(values);
    sums.column_border.add(values - 1, values, 1);
    sums.column_border.add(values + width - 1, values + width, 1);
    if (row + 1 < height) sums.add_rows(values, pair.row(row + 1) + 1, sums.rows.emplace_back());
  }
  for (const int row : {0, height}) {
    const HeightRows pair = surface.rows(row - 1, row + 1, 0);
    sums.add_rows(pair.row(row - 1), pair.row(row), sums.row_border);
  }
  return sums.result();
}

}  // namespace multum
