// SPDX-License-Identifier: Apache-2.0
#include "host/lab/field_cases/image_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace multum::reference {
namespace {

double cosine(std::size_t n, std::size_t k, std::size_t i) {
  return std::sqrt((k == 0 ? 1.0 : 2.0) / static_cast<double>(n)) *
         std::cos(std::numbers::pi * static_cast<double>((2 * i + 1) * k) / static_cast<double>(2 * n));
}

// Mirrors an index at the ends of a line of n samples until the index is within the line.
std::size_t mirrored_index(long i, long n) {
  while (i < 0 || i >= n) i = i < 0 ? -i : 2 * (n - 1) - i;
  return static_cast<std::size_t>(i);
}

// The analysis filters of the 9/7 pair (Antonini et al. 1992, table 2, h~ and g~). The code below multiplies the
// low-pass filter by sqrt(2), and the high-pass filter by sqrt(1/2). Entry k contains the tap at distance k on both
// sides. As a result, both filters have a length near 1, like the filters of orthonormal wavelets.
constexpr std::array<double, 5> kLow = {0.602949018236360, 0.266864118442875, -0.078223266528990, -0.016864118442875,
                                        0.026748757410810};
constexpr std::array<double, 4> kHigh = {1.115087052457000, -0.591271763114250, -0.057543526228500, 0.091271763114250};

template <std::size_t kTaps>
double filtered(const std::vector<double>& line, long middle, const std::array<double, kTaps>& taps) {
  const auto n = static_cast<long>(line.size());
  double sum = taps[0] * line[mirrored_index(middle, n)];
  for (std::size_t j = 1; j < kTaps; ++j)
    for (const long sign : {-1l, 1l}) sum += taps[j] * line[mirrored_index(middle + sign * static_cast<long>(j), n)];
  return sum;
}

}  // namespace

std::vector<double> block_cosines(const std::vector<double>& image, std::size_t width, std::size_t height,
                                  std::size_t side) {
  std::vector<double> coefficients;
  for (std::size_t top = 0; top < height; top += side)
    for (std::size_t left = 0; left < width; left += side)
      for (std::size_t v = 0; v < side; ++v)
        for (std::size_t u = 0; u < side; ++u) {
          double sum = 0.0;
          for (std::size_t y = 0; y < side; ++y)
            for (std::size_t x = 0; x < side; ++x)
              sum += cosine(side, v, y) * cosine(side, u, x) *
                     image[std::min(top + y, height - 1) * width + std::min(left + x, width - 1)];
          coefficients.push_back(sum);
        }
  return coefficients;
}

std::vector<double> wavelet_line(const std::vector<double>& line) {
  if (line.size() == 1) return {line.front()};
  std::vector<double> coefficients;
  const auto n = static_cast<long>(line.size());
  for (long i = 0; i < n; i += 2) coefficients.push_back(std::numbers::sqrt2 * filtered(line, i, kLow));
  for (long i = 1; i < n; i += 2) coefficients.push_back(filtered(line, i, kHigh) / std::numbers::sqrt2);
  return coefficients;
}

std::vector<double> wavelets(std::vector<double> image, std::size_t width, std::size_t height, int depth) {
  std::size_t columns = width, rows = height;
  for (; depth > 0; --depth, columns = (columns + 1) / 2, rows = (rows + 1) / 2) {
    for (std::size_t y = 0; y < rows; ++y) {
      const auto begin = image.begin() + static_cast<std::ptrdiff_t>(y * width);
      const auto line = wavelet_line({begin, begin + static_cast<std::ptrdiff_t>(columns)});
      std::copy(line.begin(), line.end(), begin);
    }
    for (std::size_t x = 0; x < columns; ++x) {
      std::vector<double> column(rows);
      for (std::size_t y = 0; y < rows; ++y) column[y] = image[y * width + x];
      column = wavelet_line(column);
      for (std::size_t y = 0; y < rows; ++y) image[y * width + x] = column[y];
    }
  }
  return image;
}

}  // namespace multum::reference
