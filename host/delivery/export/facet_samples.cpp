// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/facet_samples.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

// Interleaves the bits of x and y, beginning with the lowest bit of x.
std::uint32_t interleaved_bits(std::uint32_t x, std::uint32_t y) {
  std::uint32_t code = 0;
  for (std::uint32_t bit = 0; bit < 16; ++bit) code |= (x >> bit & 1u) << (2 * bit) | (y >> bit & 1u) << (2 * bit + 1);
  return code;
}

// The first component of the (0, 2)-sequence is van der Corput's sequence, the second is Sobol's.
double van_der_corput(std::uint32_t n) {
  double value = 0.0, digit = 0.5;
  for (; n != 0; n >>= 1, digit *= 0.5) value += (n & 1u) != 0 ? digit : 0.0;
  return value;
}

double sobol(std::uint32_t n) {
  std::uint32_t value = 0;
  for (std::uint32_t v = 0x80000000u; n != 0; n >>= 1, v ^= v >> 1)
    if ((n & 1u) != 0) value ^= v;
  return static_cast<double>(value) * 0x1p-32;
}

// Returns the maximum-likelihood alpha of isotropic slopes with mean 0. This alpha solves 1 = mean of w |x|^2 / (2 s),
// where w = 4 / (2 + |x|^2 / s) and s = alpha^2 / 2. The right side decreases as s grows.
double likeliest_alpha(const std::vector<glm::dvec2>& slopes) {
  double low = 1e-3, high = 1e3;
  for (int i = 0; i < 200; ++i) {
    const double s = std::sqrt(low * high);
    double sum = 0.0;
    for (const glm::dvec2& x : slopes) {
      const double square = x.x * x.x + x.y * x.y;
      sum += 4.0 / (2.0 + square / s) * square / 2.0;
    }
    (sum / static_cast<double>(slopes.size()) > s ? low : high) = s;
  }
  return std::sqrt(2.0 * low);
}

}  // namespace

int sample_grid(int level) { return std::clamp(1 << std::min(level, 5), 8, 32); }

std::vector<glm::vec2> facet_samples(int grid) {
  MULTUM_CHECK(grid >= 1 && grid <= 64 && (grid & (grid - 1)) == 0);
  const double half_step = 0.5 / (static_cast<double>(grid) * grid);
  std::vector<glm::dvec2> slopes;
  for (int y = 0; y < grid; ++y)
    for (int x = 0; x < grid; ++x) {
      const std::uint32_t n = interleaved_bits(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
      const double u = van_der_corput(n) + half_step, azimuth = 2.0 * std::numbers::pi * (sobol(n) + half_step);
      slopes.push_back(std::sqrt(u / (1.0 - u)) * glm::dvec2(std::cos(azimuth), std::sin(azimuth)));
    }
  const double scale = 1.0 / likeliest_alpha(slopes);
  std::vector<glm::vec2> scaled;
  for (const glm::dvec2& slope : slopes) scaled.emplace_back(scale * slope);
  return scaled;
}

}  // namespace multum
