// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/pixel_footprint.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>

namespace multum::reference {
namespace {

// Returns the texel for index i on an axis of `count` texels, or nullopt beyond a black border (OpenGL 4.5, table
// 8.20).
std::optional<int> texel_of(int i, int count, WrapMode mode) {
  if (mode == WrapMode::kBlack && (i < 0 || i >= count)) return std::nullopt;
  if (mode == WrapMode::kClamp) return std::min(std::max(i, 0), count - 1);
  while (mode == WrapMode::kPeriodic && i < 0) i += count;
  while (mode == WrapMode::kPeriodic && i >= count) i -= count;
  while (mode == WrapMode::kMirror && (i < 0 || i >= count)) i = i < 0 ? -1 - i : 2 * count - 1 - i;
  return i;
}

double value_at(const ValuePlane& plane, int x, int y, BorderModes borders) {
  const std::optional<int> column = texel_of(x, plane.width, borders.s), row = texel_of(y, plane.height, borders.t);
  if (!column || !row) return 0.0;
  return plane.values[static_cast<std::size_t>(*row) * static_cast<std::size_t>(plane.width) +
                      static_cast<std::size_t>(*column)];
}

// Computes equation 8.16 at texture coordinates s and t.
double bilinear(const ValuePlane& plane, double s, double t, BorderModes borders) {
  const double u = s * plane.width - 0.5, v = t * plane.height - 0.5;
  const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
  const double alpha = u - i, beta = v - j;
  return (1.0 - alpha) * (1.0 - beta) * value_at(plane, i, j, borders) +
         alpha * (1.0 - beta) * value_at(plane, i + 1, j, borders) +
         (1.0 - alpha) * beta * value_at(plane, i, j + 1, borders) +
         alpha * beta * value_at(plane, i + 1, j + 1, borders);
}

}  // namespace

double rectangle_average(const ValuePlane& finest, const PixelRectangle& pixel, BorderModes borders, int side_points) {
  double sum = 0.0, count = 0.0;
  for (int i = 0; i < side_points; ++i)
    for (int j = 0; j < side_points; ++j) {
      const glm::dvec2 place = pixel.centre + ((i + 0.5) / side_points - 0.5) * pixel.longer_side +
                               ((j + 0.5) / side_points - 0.5) * pixel.shorter_side;
      const int x = static_cast<int>(std::floor(place.x)), y = static_cast<int>(std::floor(place.y));
      if (borders.s == WrapMode::kClamp && (x < 0 || x >= finest.width)) continue;
      if (borders.t == WrapMode::kClamp && (y < 0 || y >= finest.height)) continue;
      sum += value_at(finest, x, y, borders);
      count += 1.0;
    }
  return sum / std::max(count, 1.0);
}

double filtered_value(const std::vector<ValuePlane>& levels, const PixelRectangle& pixel, BorderModes borders,
                      int taps_max, double level_bias) {
  const double longer = glm::length(pixel.longer_side), shorter = glm::length(pixel.shorter_side);
  const int taps = std::min(static_cast<int>(std::ceil(longer / shorter)), taps_max);
  const double coarsest = static_cast<double>(levels.size()) - 1.0;
  // If there is only one tap, its width is the longer side. If there are several taps, their width is the larger of two
  // lengths: the shorter side, and 2^(-3/4) times the part of the longer side that belongs to one tap.
  const double width = taps == 1 ? longer : std::max(shorter, longer / taps * std::pow(2.0, -0.75));
  const double lambda = std::min(std::max(std::log2(width) + level_bias, 0.0), coarsest);
  const auto fine = static_cast<std::size_t>(lambda), coarse = std::min(fine + 1, levels.size() - 1);
  const double share = lambda - static_cast<double>(fine);
  double sum = 0.0;
  for (int i = 0; i < taps; ++i) {
    const glm::dvec2 place = pixel.centre + ((2.0 * i + 1.0) / (2.0 * taps) - 0.5) * pixel.longer_side;
    const double s = place.x / levels[0].width, t = place.y / levels[0].height;
    sum += (1.0 - share) * bilinear(levels[fine], s, t, borders) + share * bilinear(levels[coarse], s, t, borders);
  }
  return sum / taps;
}

}  // namespace multum::reference
