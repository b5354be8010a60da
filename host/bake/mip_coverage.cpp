// SPDX-License-Identifier: Apache-2.0
#include "host/bake/mip_coverage.h"

#include <algorithm>
#include <cstdint>

#include "host/base/error.h"
#include "host/base/parallel.h"

namespace multum {
namespace {

struct Tap {
  int index;
  double weight;
};

// Calls body(i, share) for each of the `from` finest texels of an axis that texel x of `to` overlaps; shares sum to 1.
template <typename Body>
void for_each_overlap(std::int64_t from, std::int64_t to, std::int64_t x, const Body& body) {
  const std::int64_t begin = x * from, end = (x + 1) * from;  // in units of 1/to of a finest texel
  for (std::int64_t i = begin / to; i * to < end; ++i) {
    const std::int64_t overlap = std::min((i + 1) * to, end) - std::max(i * to, begin);
    body(static_cast<std::size_t>(i), static_cast<double>(overlap) / static_cast<double>(from));
  }
}

// For each texel of an axis: what it overlaps.
std::vector<std::vector<Tap>> axis_taps(int from, int to) {
  std::vector<std::vector<Tap>> taps(static_cast<std::size_t>(to));
  for (int x = 0; x < to; ++x)
    for_each_overlap(from, to, x, [&](std::size_t i, double share) {
      taps[static_cast<std::size_t>(x)].push_back({static_cast<int>(i), share});
    });
  return taps;
}

}  // namespace

std::vector<double> average_over_texels(const std::vector<double>& plane, PlaneSize from, PlaneSize to, int threads) {
  MULTUM_CHECK(to.width >= 1 && to.width <= from.width && to.height >= 1 && to.height <= from.height);
  const auto columns = axis_taps(from.width, to.width);
  const auto rows = axis_taps(from.height, to.height);
  const auto from_width = static_cast<std::size_t>(from.width), to_width = static_cast<std::size_t>(to.width);
  std::vector<double> result(to_width * static_cast<std::size_t>(to.height));
  for_each_item(to.height, threads, [&](int y) {
    std::vector<double> row(from_width, 0.0);
    for (const Tap& tap : rows[static_cast<std::size_t>(y)]) {
      const double* source = &plane[static_cast<std::size_t>(tap.index) * from_width];
      for (std::size_t x = 0; x < from_width; ++x) row[x] += tap.weight * source[x];
    }
    double* out = &result[static_cast<std::size_t>(y) * to_width];
    for (std::size_t x = 0; x < to_width; ++x) {
      double sum = 0.0;
      for (const Tap& tap : columns[x]) sum += tap.weight * row[static_cast<std::size_t>(tap.index)];
      out[x] = sum;
    }
  });
  return result;
}

glm::dvec3 average_over_texel(const std::array<const std::vector<float>*, 3>& planes, PlaneSize from, PlaneSize to,
                              int texel) {
  MULTUM_CHECK(texel >= 0 && texel / to.width < to.height);
  glm::dvec3 sum(0.0);
  for_each_overlap(from.height, to.height, texel / to.width, [&](std::size_t y, double row_share) {
    for_each_overlap(from.width, to.width, texel % to.width, [&](std::size_t x, double column_share) {
      const std::size_t i = y * static_cast<std::size_t>(from.width) + x;
      const glm::vec3 value((*planes[0])[i], (*planes[1])[i], (*planes[2])[i]);
      sum += row_share * column_share * glm::dvec3(value);
    });
  });
  return sum;
}

}  // namespace multum
