// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/pyramid/pyramid_sample.h"

#include <algorithm>
#include <cmath>

namespace multum {
namespace {

// Returns the index of the texel for index `i`, which may be beyond the border. -1 means black.
int wrapped(int i, int size, WrapMode mode) {
  if (i >= 0 && i < size) return i;
  switch (mode) {
    case WrapMode::kBlack: return -1;
    case WrapMode::kClamp: return std::clamp(i, 0, size - 1);
    case WrapMode::kPeriodic: return ((i % size) + size) % size;
    case WrapMode::kMirror: {
      const int place = ((i % (2 * size)) + 2 * size) % (2 * size);
      return place < size ? place : 2 * size - 1 - place;
    }
  }
  return -1;
}

// Reduces a coordinate to one period, so that its texel index fits into an int.
double reduced(double place, WrapMode mode) {
  constexpr double kFar = 1e6;  // beyond this distance, clamp and black give the same value everywhere
  const double period = mode == WrapMode::kPeriodic ? 1.0 : 2.0;
  if (mode == WrapMode::kPeriodic || mode == WrapMode::kMirror) return place - period * std::floor(place / period);
  return std::clamp(place, -kFar, kFar);
}

}  // namespace

PyramidSample sample_level(const Pyramid& pyramid, int level, double s, double t) {
  const BakedHeader& map = pyramid.header.map;
  const PyramidLevel& texels = pyramid.levels[static_cast<std::size_t>(level)];
  const auto channels = static_cast<std::size_t>(pyramid.header.channel_count());
  // Texel centres are at half-integers.
  const double x = reduced(s, map.wrap_s) * texels.width - 0.5, y = reduced(t, map.wrap_t) * texels.height - 0.5;
  const double fx = x - std::floor(x), fy = y - std::floor(y);
  PyramidSample sum{};
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const int column = wrapped(static_cast<int>(std::floor(x)) + i, texels.width, map.wrap_s);
      const int row = wrapped(static_cast<int>(std::floor(y)) + j, texels.height, map.wrap_t);
      if (column < 0 || row < 0) continue;
      const double weight = (i == 0 ? 1.0 - fx : fx) * (j == 0 ? 1.0 - fy : fy);
      const std::size_t first =
          (static_cast<std::size_t>(row) * static_cast<std::size_t>(texels.width) + static_cast<std::size_t>(column)) *
          channels;
      for (std::size_t c = 0; c < channels; ++c) sum[c] += weight * static_cast<double>(texels.values[first + c]);
    }
  return sum;
}

PyramidSample sample_pyramid(const Pyramid& pyramid, double s, double t, double d) {
  const int last = pyramid.header.level_count() - 1;
  const double level = std::clamp(d, 0.0, static_cast<double>(last));
  const int fine = std::min(static_cast<int>(level), last), coarse = std::min(fine + 1, last);
  const double share = level - fine;
  PyramidSample sample = sample_level(pyramid, fine, s, t);
  if (share == 0.0) return sample;
  const PyramidSample other = sample_level(pyramid, coarse, s, t);
  for (std::size_t c = 0; c < sample.size(); ++c) sample[c] += share * (other[c] - sample[c]);
  return sample;
}

double mip_level_of(const TexelDerivatives& d) {
  return std::log2(std::max(std::hypot(d.u_x, d.v_x), std::hypot(d.u_y, d.v_y)));
}

}  // namespace multum
