// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/axis_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kBlock = 4;           // finest texels per side
constexpr int kBinCount = 180;      // bins of one degree
constexpr double kSharpness = 8.0;  // sharpness of an axis's influence around its angle; 17 degrees away, the influence
                                    // is half as large
constexpr int kBlockRows = 256;     // largest number of block rows; enough for a histogram in steps of one degree

using Bins = std::array<double, kBinCount>;

// Adds the axis along which x and y of a block's normals vary most. The weight of the axis is the difference between
// the variances along and across it.
void add_block(const std::vector<float>& x, const std::vector<float>& y, std::size_t width, std::size_t first,
               Bins& bins) {
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
  for (std::size_t row = 0; row < kBlock; ++row)
    for (std::size_t column = 0; column < kBlock; ++column) {
      const std::size_t i = row * width + first + column;
      const double u = static_cast<double>(x[i]), v = static_cast<double>(y[i]);
      sx += u, sy += v, sxx += u * u, sxy += u * v, syy += v * v;
    }
  constexpr double kShare = 1.0 / (kBlock * kBlock);
  const double xx = kShare * sxx - kShare * kShare * sx * sx, yy = kShare * syy - kShare * kShare * sy * sy;
  const double xy = kShare * sxy - kShare * kShare * sx * sy;
  double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
  if (angle < 0.0) angle += std::numbers::pi;
  const auto bin = static_cast<std::size_t>(angle / std::numbers::pi * kBinCount);
  bins[std::min<std::size_t>(bin, kBinCount - 1)] += std::hypot(xx - yy, 2.0 * xy);
}

}  // namespace

double find_axis_cut(const PlaneStore& normals) {
  const std::size_t width = size_of(normals.width());
  const int block_rows = normals.height() / kBlock;
  Bins bins{};
  std::vector<float> x(kBlock * width), y(x), z(x);
  const int step = std::max(1, block_rows / kBlockRows);
  for (int row = 0; row < block_rows; row += step) {
    normals.read_rows(row * kBlock, kBlock, {x.data(), y.data(), z.data()});
    for (std::size_t column = 0; column + kBlock <= width; column += kBlock) add_block(x, y, width, column, bins);
  }
  // Each axis has a small influence at all angles, so the minimum is in the middle of an empty range. If there are no
  // axes, the cut points straight down, so that directions point to the right.
  double least = -1.0;
  int cut = kBinCount / 2;
  for (int i = 0; i < kBinCount; ++i) {
    const int bin = (kBinCount / 2 + i) % kBinCount;
    double sum = 0.0;
    for (int k = 0; k < kBinCount; ++k)
      sum += std::exp(kSharpness * (std::cos(2.0 * std::numbers::pi * (k - bin) / kBinCount) - 1.0)) * bins[size_of(k)];
    if (least >= 0.0 && sum >= least) continue;
    least = sum;
    cut = bin;
  }
  return (cut + 0.5) * std::numbers::pi / kBinCount;
}

glm::vec2 signed_axis(glm::vec2 axis, double cut) {
  // The half plane to the left of the cut's direction is between `cut` and `cut` + pi.
  const double left = std::cos(cut) * static_cast<double>(axis.y) - std::sin(cut) * static_cast<double>(axis.x);
  return left < 0.0 ? -axis : axis;
}

}  // namespace multum
