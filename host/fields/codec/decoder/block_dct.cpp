// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/block_dct.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace multum {
namespace {

constexpr std::size_t kSideMax = 32;

/// Sets row k to sqrt(2 / n) cos(pi (2 i + 1) k / (2 n)). The first row is also multiplied by sqrt(1/2).
std::vector<float> cosines(std::size_t n) {
  std::vector<float> rows(n * n);
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < n; ++i)
      rows[k * n + i] = static_cast<float>(
          std::sqrt((k == 0 ? 1.0 : 2.0) / static_cast<double>(n)) *
          std::cos(std::numbers::pi * static_cast<double>((2 * i + 1) * k) / static_cast<double>(2 * n)));
  return rows;
}

}  // namespace

bool is_dct_side(int side) { return side == 8 || side == 16 || side == 32; }

std::span<const float> dct_cosines(int side) {
  static const std::array<std::vector<float>, 3> tables = {cosines(8), cosines(16), cosines(32)};
  return tables[side == 8 ? 0 : side == 16 ? 1 : 2];
}

void forward_dct(int side, std::span<const float> samples, std::span<float> coefficients) {
  const auto n = static_cast<std::size_t>(side);
  const std::span<const float> rows = dct_cosines(side);
  std::array<float, kSideMax * kSideMax> half{};  // [y][u]
  for (std::size_t y = 0; y < n; ++y)
    for (std::size_t u = 0; u < n; ++u) {
      float sum = 0.0f;
      for (std::size_t x = 0; x < n; ++x) sum += rows[u * n + x] * samples[y * n + x];
      half[y * n + u] = sum;
    }
  for (std::size_t v = 0; v < n; ++v) {
    std::array<float, kSideMax> sums{};
    for (std::size_t y = 0; y < n; ++y)
      for (std::size_t u = 0; u < n; ++u) sums[u] += rows[v * n + y] * half[y * n + u];
    std::copy_n(sums.begin(), n, coefficients.begin() + static_cast<std::ptrdiff_t>(v * n));
  }
}

void inverse_dct(int side, std::span<const float> coefficients, std::span<float> samples) {
  const auto n = static_cast<std::size_t>(side);
  const std::span<const float> rows = dct_cosines(side);
  std::array<float, kSideMax * kSideMax> half{};  // [v][x]
  std::array<bool, kSideMax> used{};
  for (std::size_t v = 0; v < n; ++v)
    for (std::size_t u = 0; u < n; ++u) {
      const float value = coefficients[v * n + u];
      if (value == 0.0f) continue;
      used[v] = true;
      for (std::size_t x = 0; x < n; ++x) half[v * n + x] += value * rows[u * n + x];
    }
  std::fill_n(samples.begin(), n * n, 0.0f);
  for (std::size_t v = 0; v < n; ++v) {
    if (!used[v]) continue;
    for (std::size_t y = 0; y < n; ++y)
      for (std::size_t x = 0; x < n; ++x) samples[y * n + x] += rows[v * n + y] * half[v * n + x];
  }
}

}  // namespace multum
