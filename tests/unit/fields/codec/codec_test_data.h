// SPDX-License-Identifier: Apache-2.0
// Makes inputs that the tests of the codec share: random bytes and pictures, filter matrices, damaged copies, and
// errors.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "host/fields/inferred/filter_matrix.h"
#include "host/foundation/base/split_mix.h"

namespace multum {

inline std::vector<std::uint8_t> random_bytes(SplitMix64& random, std::size_t count) {
  std::vector<std::uint8_t> bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.next());
  return bytes;
}

/// Returns a copy with some bytes changed, cut or repeated.
inline std::vector<std::uint8_t> damaged(std::vector<std::uint8_t> bytes, SplitMix64& random) {
  if (bytes.empty()) return bytes;
  const auto place = [&] { return static_cast<std::size_t>(random.next() % bytes.size()); };
  for (std::uint64_t i = 1 + random.next() % 4; i > 0; --i) bytes[place()] = static_cast<std::uint8_t>(random.next());
  if (random.next() % 3 == 0) bytes.resize(place());
  if (random.next() % 4 == 0) {
    const auto more = random_bytes(random, random.next() % 64);
    bytes.insert(bytes.end(), more.begin(), more.end());
  }
  return bytes;
}

/// Makes waves and an edge, with noise of the given size. The values are about 0 to 255.
inline std::vector<float> test_plane(std::size_t width, std::size_t height, double phase, double noise,
                                     SplitMix64& random) {
  std::vector<float> plane(width * height);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      plane[y * width + x] = static_cast<float>(
          120.0 + 50.0 * std::sin(0.13 * static_cast<double>(x) + phase) * std::cos(0.21 * static_cast<double>(y)) +
          (2 * x > width + y ? 40.0 : 0.0) + noise * (random.uniform() - 0.5));
  return plane;
}

/// Makes pixels that average squares of `block` x `block` texels in the finest level. Only the columns from `begin` to
/// `end` have pixels.
inline FilterMatrix seen_columns(int width, int height, int block, int begin, int end) {
  FilterMatrix matrix;
  matrix.width = width / block;
  matrix.height = height / block;
  matrix.texture_width = width;
  matrix.texture_height = height;
  matrix.row_begin.push_back(0);
  for (int y = 0; y < height / block; ++y)
    for (int x = begin / block; x < end / block; ++x) {
      matrix.pixels.push_back(static_cast<std::uint32_t>(y * matrix.width + x));
      matrix.coverage.push_back(1.0f);
      for (int j = 0; j < block; ++j)
        for (int i = 0; i < block; ++i) {
          matrix.columns.push_back(static_cast<std::uint32_t>((y * block + j) * width + x * block + i));
          matrix.weights.push_back(1.0f / static_cast<float>(block * block));
        }
      matrix.row_begin.push_back(static_cast<std::uint32_t>(matrix.columns.size()));
    }
  return matrix;
}

inline double mean_square(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2.0);
  return sum / static_cast<double>(a.size());
}

}  // namespace multum
