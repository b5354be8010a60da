// SPDX-License-Identifier: Apache-2.0
// Noise with a period of 1 in both directions, for materials: gradient noise (Perlin 1985, 2002), and cells with one
// random point each (Worley 1996).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <glm/common.hpp>
#include <glm/vec2.hpp>

#include "host/foundation/base/split_mix.h"

namespace multum {

inline constexpr double kWholeTurn = 2.0 * std::numbers::pi;

/// Returns i modulo n, from 0 to n - 1.
inline int wrapped_cell(int i, int n) { return ((i % n) + n) % n; }

/// Returns a random number from 0 to 1 for a cell. `axis` distinguishes several numbers of one cell.
inline double cell_random(int x, int y, int axis, std::uint64_t seed) {
  const std::uint64_t of_axis = split_mix(seed + static_cast<std::uint64_t>(axis));
  const std::uint64_t of_column = split_mix(of_axis + static_cast<std::uint32_t>(x));
  return static_cast<double>(split_mix(of_column + static_cast<std::uint32_t>(y)) >> 11) * 0x1.0p-53;
}

inline double smooth(double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); }
/// Returns 0 below `from`, 1 above `to`, and a smooth transition between them.
inline double smooth_step(double from, double to, double value) {
  return smooth(std::clamp((value - from) / (to - from), 0.0, 1.0));
}

/// Returns gradient noise with `count` cells per period, about -1 to 1.
inline double gradient_noise(double u, double v, int count, std::uint64_t seed) {
  const double x = u * count, y = v * count;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const auto corner = [&](int i, int j) {
    const double turn = kWholeTurn * cell_random(wrapped_cell(x0 + i, count), wrapped_cell(y0 + j, count), 0, seed);
    return std::cos(turn) * (x - x0 - i) + std::sin(turn) * (y - y0 - j);
  };
  const double s = smooth(x - x0), t = smooth(y - y0);
  return std::numbers::sqrt2 *
         glm::mix(glm::mix(corner(0, 0), corner(1, 0), s), glm::mix(corner(0, 1), corner(1, 1), s), t);
}

/// Returns the sum of `octaves` of gradient noise. Each has twice the cells and half the height of the one before.
inline double fractal_noise(double u, double v, int count, int octaves, std::uint64_t seed) {
  double sum = 0.0, height = 1.0;
  for (int octave = 0; octave < octaves; ++octave, height *= 0.5)
    sum += height * gradient_noise(u, v, count << octave, seed + static_cast<std::uint64_t>(octave));
  return sum;
}

/// Calls `body(cell, away)` for the points of the 3 x 3 cells around a place. `away` is the vector from the point to
/// the place, in cells.
template <typename Body>
void for_near_points(double u, double v, int count, std::uint64_t seed, const Body& body) {
  const double x = u * count, y = v * count;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  for (int j = y0 - 1; j <= y0 + 1; ++j)
    for (int i = x0 - 1; i <= x0 + 1; ++i) {
      const glm::ivec2 cell(wrapped_cell(i, count), wrapped_cell(j, count));
      const glm::dvec2 point(i + cell_random(cell.x, cell.y, 1, seed), j + cell_random(cell.x, cell.y, 2, seed));
      body(cell, glm::dvec2(x, y) - point);
    }
}

}  // namespace multum
